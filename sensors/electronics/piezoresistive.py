"""The piezoresistive chain: load -> hysteresis, creep -> conductance -> scan -> noise -> ADC -> force by calibration.

Divider and supply are FVSight's (U = VCC R / (R1 + R), eq. 1 of its paper; 3.3 V, 10 kOhm, 16 bits, rows isolated while
scanned, so no crosstalk). The conductance law G = G0 + c F^0.9 is a stated model: c puts the middle of
the range at 5 N.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sensors.electronics.creep import Creep
from sensors.electronics.given import finite_load
from sensors.electronics.hysteresis import PrandtlIshlinskii
from sensors.electronics.scanning import Scanning, correct_grounded_rows, scan

_CALIBRATED_N = 200.0
"""Beyond this load the static calibration of a creeping sheet goes on at unit slope."""
Preset = Literal["fvsight", "velostat"]

LOW_HYSTERESIS = PrandtlIshlinskii((0.5, 2.0, 6.0, 15.0), (0.004,) * 4)
"""0.19 N between the branches of a 50 N cycle, 0.4 % of full scale."""


@dataclass(frozen=True)
class PiezoresistiveChain:
    """Parameters of one array; forces in newtons, conductances in siemens.

    `rows` is how many rows the array has where they are not isolated. `press_spread` is the log-normal spread of the
    conductance from press to press; one `read` is one press. `compensate_hysteresis` inverts the hysteresis exactly
    instead of by its loading branch alone, `correct_crosstalk` what grounded rows do.
    """

    supply_v: float = 3.3
    divider_ohm: float = 10e3
    adc_bits: int = 16
    rest_conductance_s: float = 1e-6
    midscale_force_n: float = 5.0
    exponent: float = 0.9
    noise_v: float = 1e-3
    hysteresis: PrandtlIshlinskii | None = LOW_HYSTERESIS
    compensate_hysteresis: bool = False
    creep: Creep | None = None
    rate_hz: float = 1000.0
    press_spread: float = 0.0
    scanning: Scanning = "isolated"
    rows: int = 4
    correct_crosstalk: bool = True

    def __post_init__(self) -> None:
        if self.compensate_hysteresis and (self.hysteresis is None or self.creep is not None):
            raise ValueError("compensate_hysteresis needs a chain with hysteresis and without creep: set creep=None")
        positive = (self.supply_v, self.divider_ohm, self.midscale_force_n, self.exponent, self.rate_hz)
        if not all(0 < value < np.inf for value in positive):
            raise ValueError("a chain needs supply, divider, midscale force, exponent and rate > 0")
        others = (self.rest_conductance_s, self.noise_v, self.press_spread)
        if not all(0 <= value < np.inf for value in others) or self.adc_bits < 1 or self.rows < 1:
            raise ValueError("a chain needs rest conductance, noise and spread >= 0, adc_bits and rows >= 1")

    @property
    def conductance_coefficient(self) -> float:
        """c in S / N^exponent: the divider gives half the supply at `midscale_force_n`."""
        return 1 / (self.divider_ohm * self.midscale_force_n**self.exponent)

    def respond(self, load: NDArray[np.float64]) -> NDArray[np.float64]:
        """Hysteretic response (N) to true loads (T, taxels)."""
        return load if self.hysteresis is None else self._in_closed_contacts(load, self.hysteresis.respond(load))

    def _in_closed_contacts(self, load: NDArray[np.float64], response: NDArray[np.float64]) -> NDArray[np.float64]:
        """A creeping sheet is hysteretic where its contacts are closed: a released one has no remanence."""
        return response if self.creep is None else load + (response - load) * self.creep.closed(load)

    def conductance(
        self, response: NDArray[np.float64], gain: NDArray[np.float64] | float = 1.0
    ) -> NDArray[np.float64]:
        """Conductance (S) for a hysteretic response (N); `gain` scales what the load adds, taxel by taxel."""
        power = np.sign(response) * np.abs(response) ** self.exponent
        total = self.rest_conductance_s + self.conductance_coefficient * gain * power
        return total if self.creep is None else total * self.creep.factor(response, self.rate_hz)

    def voltage(
        self,
        response: NDArray[np.float64],
        gain: NDArray[np.float64] | float = 1.0,
        dead: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.float64]:
        """Divider voltage (V) for a hysteretic response (N); `dead` taxels (taxels,) are open circuits."""
        # a conductance below zero has no meaning; an open circuit reads zero volts
        load_ratio = np.maximum(self.divider_ohm * self.conductance(response, gain), 0)
        if dead is not None:
            load_ratio = np.where(dead, 0, load_ratio)
        if self.scanning == "isolated":
            return self.supply_v * load_ratio / (1 + load_ratio)
        return self._flat(scan(self._matrix(load_ratio), 1.0, self.supply_v, self.scanning), load_ratio)

    def convert(self, voltage: NDArray[np.float64]) -> NDArray[np.float64]:
        """The voltage (V) that the ADC reports: clipped to the supply and rounded to its step."""
        steps = 2**self.adc_bits - 1
        return np.round(np.clip(voltage / self.supply_v, 0, 1) * steps) / steps * self.supply_v

    def calibrated_force(self, voltage: NDArray[np.float64]) -> NDArray[np.float64]:
        """Force (N) by the static calibration on a nominal taxel's loading branch, of a sheet long under its load."""
        if self.scanning == "grounded_rows" and self.correct_crosstalk:
            conductance = correct_grounded_rows(self._matrix(voltage), self.divider_ohm, self.supply_v)
            excess = self._flat(conductance, voltage) - self.rest_conductance_s
        else:
            ratio = np.minimum(voltage / self.supply_v, 1 - 2.0**-self.adc_bits)
            excess = ratio / (1 - ratio) / self.divider_ohm - self.rest_conductance_s
        response = np.sign(excess) * (np.abs(excess) / self.conductance_coefficient) ** (1 / self.exponent)
        return response if self.hysteresis is None else self._undo(self.hysteresis, response)

    def _undo(self, hysteresis: PrandtlIshlinskii, response: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.compensate_hysteresis:
            return hysteresis.invert(response)
        if self.creep is None:
            return hysteresis.invert_loading(response)
        knots = np.concatenate(([0.0], np.geomspace(1e-3, _CALIBRATED_N, 800)))
        values = self._in_closed_contacts(knots, hysteresis.loading_branch(knots))
        size = np.abs(response)
        return np.sign(response) * (np.interp(size, values, knots) + np.maximum(size - values[-1], 0))

    def read(
        self,
        load: NDArray[np.float64],
        rng: np.random.Generator | None = None,
        gain: NDArray[np.float64] | float = 1.0,
        dead: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.float64]:
        """Read-back forces (N) for true taxel loads (T, taxels) from rest; neither noise nor spread without `rng`.

        Raises ValueError for a load or gain that is not finite, a gain < 0, and where `rows` do not divide the taxels
        of an array whose rows are not isolated.
        """
        load = finite_load(load, gain)
        if rng is not None and self.press_spread > 0:
            gain = gain * np.exp(self.press_spread * rng.standard_normal(load.shape[1:]))
        voltage = self.voltage(self.respond(load), gain, dead)
        if rng is not None and self.noise_v > 0:
            voltage = voltage + rng.normal(0.0, self.noise_v, voltage.shape)
        return self.calibrated_force(self.convert(voltage))

    def _matrix(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values (T, taxels) as (T, rows, columns)."""
        taxels = values.shape[-1]
        if taxels % self.rows:
            raise ValueError(f"{taxels} taxels do not fill {self.rows} rows: set `rows` of the chain")
        return values.reshape(-1, self.rows, taxels // self.rows)

    def _flat(self, matrix: NDArray[np.float64], like: NDArray[np.float64]) -> NDArray[np.float64]:
        return matrix.reshape(like.shape)


VELOSTAT = PiezoresistiveChain(
    rest_conductance_s=2e-5,
    exponent=0.95,
    hysteresis=PrandtlIshlinskii((0.5, 2.0, 6.0, 15.0), (0.03,) * 4),
    creep=Creep((0.32, 2.0), (0.14, 0.095), closing_force_n=0.3),
    press_spread=0.2,
)
"""A bare carbon-filled sheet: creep, overshoot and spread chosen inside what public recordings of Velostat show.

Not a fit to one recording: `sensors.calibration` draws its transients beside those ranges.
"""

PRESETS: dict[Preset, PiezoresistiveChain] = {"fvsight": PiezoresistiveChain(), "velostat": VELOSTAT}
