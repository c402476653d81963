"""Every registered sensor goes through the same battery: load kept, deterministic, shapes and units, refusals.

Sensors whose skin is a pressure field go through a second one.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from sensors import Digit, FVSightParameters, FVSightUnit, GelSight
from sensors.catalogue import SENSORS
from sensors.contact.grid import Grid
from sensors.contact.solver import NO_SURFACE, ContactSolution


@pytest.fixture(scope="module", params=list(SENSORS))
def registered(request):
    return SENSORS[request.param]


def touch(registered, share=1.0, seed=0):
    return registered.sample_touch(share * registered.load_n, np.random.default_rng(seed))


def test_the_contact_carries_the_load(registered):
    assert touch(registered).carried_n == pytest.approx(registered.load_n, rel=0.01)


def test_readings_and_frames_are_as_stated(registered):
    found = touch(registered)
    assert found.force_series is not None or found.frame is not None
    if found.frame is not None:
        assert found.frame.dtype == np.uint8
        assert found.frame.ndim == 3
        assert found.frame.shape[2] == 3
    if found.force_series is not None:
        assert found.force_series.dtype == np.float32
        assert np.isfinite(found.force_series).all()
        taxels, rate = (float(word) for word in re.findall(r"(\d+) taxels.* (\d+)", registered.gives)[0])
        assert found.force_series.shape[1] == taxels
        assert found.rate_hz == pytest.approx(1000 / rate if registered.gives.endswith("ms") else rate)
        assert f"in {found.force_unit}" in registered.gives


def test_readings_in_newtons_sum_to_the_load(registered):
    found = touch(registered)
    if found.force_unit == "N":
        # spread and drift of a unit are part of what it reads
        assert found.force_series[-1].sum() == pytest.approx(registered.load_n, rel=0.1)


def test_the_seed_decides_everything(registered):
    first, again = touch(registered, seed=3), touch(registered, seed=3)
    for one, other in ((first.force_series, again.force_series), (first.frame, again.frame)):
        assert (one is None) == (other is None)
        assert one is None or one.tobytes() == other.tobytes()


def test_more_load_gives_other_readings_and_frames(registered):
    light, heavy = touch(registered, 0.2), touch(registered)
    if heavy.force_series is not None:
        assert heavy.force_series[-1].sum() > 2 * light.force_series[-1].sum()
    if heavy.frame is not None:
        assert np.abs(heavy.frame.astype(int) - light.frame).max() > 8


@pytest.mark.parametrize("load_n", [0.0, -1.0, np.nan, np.inf])
def test_loads_without_meaning_are_refused(registered, load_n):
    with pytest.raises(ValueError, match="load_n"):
        registered.sample_touch(load_n, np.random.default_rng(0))


@dataclass(frozen=True)
class Pressed:
    contact: ContactSolution
    frame: np.ndarray


def _fvsight(parameters: FVSightParameters) -> tuple[Grid, Callable[[np.ndarray, float], Pressed]]:
    unit = FVSightUnit(parameters, 0)

    def press(gap: np.ndarray, load_n: float) -> Pressed:
        solved = unit.press(gap, load_n)
        rng = np.random.default_rng(0)
        return Pressed(solved.contact, unit.frame(solved.surface_modes, unit.session(None), rng))

    return unit.grid, press


def _gel(sensor: GelSight | Digit) -> tuple[Grid, Callable[[np.ndarray, float], Pressed]]:
    def press(gap: np.ndarray, load_n: float) -> Pressed:
        solved = sensor.press(gap, load_n=load_n, rng=np.random.default_rng(0))
        return Pressed(solved.contact, solved.frame)

    return sensor.grid, press


SOFT_PAD = FVSightParameters(support="plate", grid=64, film_thickness_mm=4.0, film_modulus_mpa=0.3)
MAKERS = {
    "fvsight": lambda: _fvsight(FVSightParameters(grid=64)),
    "fvsight on a plate": lambda: _fvsight(SOFT_PAD),
    "gelsight": lambda: _gel(GelSight()),
    "digit": lambda: _gel(Digit()),
}
LOADS_N = {"fvsight": 3.0, "fvsight on a plate": 3.0, "gelsight": 0.3, "digit": 0.1}


@pytest.fixture(scope="module", params=list(MAKERS))
def sensor(request):
    grid, press = MAKERS[request.param]()
    return grid, press, LOADS_N[request.param]


def ball(grid: Grid) -> np.ndarray:
    x, y = grid.coordinates()
    radius = grid.size_m / 8
    return (x**2 + y**2) / (2 * radius)


def test_pressure_carries_the_load(sensor):
    grid, press, load_n = sensor
    contact = press(ball(grid), load_n).contact
    carried = contact.pressure.sum(dtype=np.float64) * grid.cell_area_m2
    assert carried == pytest.approx(load_n, rel=0.01)
    assert contact.force_n == pytest.approx(load_n, rel=0.01)


@pytest.mark.parametrize("times", [100, 1e5])
def test_a_press_deeper_than_the_model_holds_is_refused_in_one_line(sensor, times):
    """A skin by its stretching, a pad by its thickness: no frame of a ball that stands in the window."""
    grid, press, load_n = sensor
    with pytest.raises(ValueError, match=r"sinks .* mm.*lower the load"):
        press(ball(grid), times * load_n)


def test_pressure_never_pulls(sensor):
    grid, press, load_n = sensor
    assert (press(ball(grid), load_n).contact.pressure >= 0).all()


def test_more_load_sinks_deeper(sensor):
    grid, press, load_n = sensor
    light, heavy = (press(ball(grid), load).contact.indentation_m for load in (load_n / 2, load_n))
    assert 0 < light < heavy


def test_frames_are_eight_bit_colour_and_repeat(sensor):
    grid, press, load_n = sensor
    first, again = (press(ball(grid), load_n).frame for _ in range(2))
    assert first.dtype == np.uint8
    assert first.shape[2] == 3
    assert np.array_equal(first, again)


def test_a_press_shows_in_the_frame(sensor):
    grid, press, load_n = sensor
    light, heavy = (press(ball(grid), load).frame.astype(int) for load in (load_n / 10, load_n))
    assert np.abs(heavy - light).max() > 8


@pytest.mark.parametrize(("value", "message"), [(np.nan, "NaN"), (NO_SURFACE, "surface")])
def test_impossible_surfaces_are_refused(sensor, value, message):
    grid, press, load_n = sensor
    with pytest.raises(ValueError, match=message):
        press(np.full((grid.n, grid.n), value), load_n)
