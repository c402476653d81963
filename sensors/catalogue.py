"""The registered sensors. A new one is a file with a class, its parameters and `sample_touch`, and a line in `SENSORS`.

Everything registered here is listed by `vtbench list sensors` and goes through the contract tests.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from sensors.touch import Touch

_HELD_SAMPLES = 200


@dataclass(frozen=True)
class Registered:
    """A sensor's module, what it gives, a load (N) it takes well, and a press of a ball with such a load.

    `touch` takes the load and a generator; by default it is `sample_touch` of the module.
    """

    module: str
    gives: str
    load_n: float
    touch: Callable[[float, np.random.Generator], Touch] | None = None

    def sample_touch(self, load_n: float, rng: np.random.Generator) -> Touch:
        """Press something on the sensor with `load_n`. ValueError for a load that is not > 0 and finite."""
        if not 0 < load_n < np.inf:
            raise ValueError(f"a press needs load_n > 0, got {load_n}")
        touch = self.touch or import_module(self.module).sample_touch
        made: Touch = touch(load_n, rng)
        return made

    @property
    def about(self) -> str:
        """First line of the module's docstring."""
        return str(import_module(self.module).__doc__).strip().splitlines()[0].rstrip(".")


def _fvsight(load_n: float, rng: np.random.Generator) -> Touch:
    from sensors.fvsight import FORCE_RATE_HZ, FVSightParameters, FVSightUnit
    from sensors.gel_pad import ball_gap
    from sensors.touch import Touch

    unit = FVSightUnit(FVSightParameters(grid=64), 0)
    pressed = unit.press(ball_gap(unit.grid, unit.grid.size_m / 8), load_n)
    session = unit.session(rng)
    series = unit.read(np.repeat(pressed.taxel_load[None], _HELD_SAMPLES, axis=0), session, rng)
    frame = unit.frame(pressed.surface_modes, session, rng)
    return Touch(float(pressed.taxel_load.sum()), series, FORCE_RATE_HZ, "N", frame)


def _gel(sensor: Any, load_n: float, rng: np.random.Generator) -> Touch:
    from sensors.gel_pad import ball_gap
    from sensors.touch import Touch

    pressed = sensor.press(ball_gap(sensor.grid, sensor.grid.size_m / 8), load_n=load_n, rng=rng)
    pressure = pressed.contact.pressure.sum(dtype=np.float64)
    return Touch(float(pressure * sensor.grid.cell_area_m2), frame=pressed.frame)


def _gelsight(load_n: float, rng: np.random.Generator) -> Touch:
    from sensors.gelsight import GelSight

    return _gel(GelSight(), load_n, rng)


def _digit(load_n: float, rng: np.random.Generator) -> Touch:
    from sensors.digit import Digit

    return _gel(Digit(), load_n, rng)


SENSORS: dict[str, Registered] = {
    "fvsight": Registered("sensors.fvsight", "frame, 16 taxels in N at 1000 Hz", 3.0, _fvsight),
    "gelsight": Registered("sensors.gelsight", "frame", 0.3, _gelsight),
    "digit": Registered("sensors.digit", "frame", 0.1, _digit),
    "cpm_finger": Registered("sensors.cpm_finger", "16 taxels in counts every 28 ms", 5.0),
    "taxel_pad": Registered("sensors.taxel_pad", "84 taxels in N at 240 Hz", 3.0),
}
