"""Variants of FVSight's array: a bare sheet, floating rows, dead taxels; without them nothing changes."""

import numpy as np
import pytest

from sensors.fvsight import FVSightParameters, FVSightUnit
from sensors.scene import PressScene

HELD = np.tile(np.where(np.isin(np.arange(16), (0, 3, 12)), 8.0, 0.0), (1500, 1))


def read(**change):
    unit = FVSightUnit(FVSightParameters(grid=16, force_noise_mv=0.0, **change), 0)
    return unit.read(HELD, unit.session(None), np.random.default_rng(0))


def test_a_bare_sheet_creeps_and_the_films_array_does_not():
    chains = ({"taxels": "velostat"}, {}, {"taxels": "velostat", "creep": False})
    grown = [series[1400, 0] / series[0, 0] for series in (read(**chain) for chain in chains)]
    assert grown[0] > 1.1
    assert grown[1:] == pytest.approx([1, 1], abs=1e-3)


def test_floating_rows_raise_the_fourth_corner_and_grounded_ones_do_not():
    assert read(scanning="floating")[-1, 15] > 1
    assert read(scanning="grounded_rows")[-1, 15] == pytest.approx(0, abs=0.05)
    assert read()[-1, 15] == pytest.approx(0, abs=0.05)


def test_dead_taxels_stay_silent_and_leave_the_others_alone():
    whole, broken = read(), read(dead_taxels=(3,))
    assert broken[:, 3] == pytest.approx(0, abs=0.05)
    others = np.arange(16) != 3
    assert np.array_equal(whole[:, others], broken[:, others])
    with pytest.raises(ValueError, match=r"dead_taxels must lie in 0\.\.15"):
        FVSightParameters(dead_taxels=(16,))


def test_variants_are_named_where_they_are_used_only():
    plain, varied = FVSightParameters(), FVSightParameters(taxels="velostat", dead_taxels=(1, 2))
    assert not {"taxels", "scanning", "dead_taxels", "creep"} & set(plain.model_dump())
    assert varied.model_dump()["taxels"] == "velostat"
    for parameters in (plain, varied):
        scene = PressScene(id="x", title="x", sensor=parameters)
        assert PressScene(**scene.model_dump(mode="json")) == scene


def test_creep_is_an_effect_that_is_named_where_it_is_switched_only():
    plain, still = (
        PressScene(id="x", title="x", sensor={"taxels": "velostat"}, effects=effects)
        for effects in ({}, {"creep": False})
    )
    assert "creep" not in plain.model_dump()["effects"] | plain.effective_sensor().model_dump()
    assert still.model_dump()["effects"]["creep"] is still.effective_sensor().model_dump()["creep"] is False
    assert still.effective_sensor() == plain.sensor.model_copy(update={"creep": False})
    assert PressScene(**still.model_dump(mode="json")) == still


@pytest.mark.parametrize(
    "change",
    [
        {"region_mm": 1e6},
        {"film_thickness_mm": np.inf},
        {"film_modulus_mpa": np.inf},
        {"session_gain_drift": 3},
        {"session_offset_n": np.inf},
        {"session_light_drift": 1000},
        {"unit_gain_spread": 3},
        {"taxel_gain_spread": 50},
        {"led_power_spread": 100},
        {"led_azimuth_spread_deg": 400},
        {"camera_offset_mm": 500},
        {"tension_spread": np.nan},
    ],
    ids=lambda change: next(iter(change)),
)
def test_a_sensor_that_cannot_be_is_refused_by_the_name_of_what_makes_it(change):
    with pytest.raises(ValueError, match=next(iter(change))):
        FVSightParameters(**change)


def draws_living_factors(parameters, number):
    try:
        unit = FVSightUnit(parameters, number)
        session = unit.session(np.random.default_rng(number))
    except ValueError:
        return False
    assert min(unit.taxel_gain.min(), session.gain.min(), session.light.min()) > 0
    return True


def test_every_factor_that_a_wide_spread_draws_is_positive_or_refused():
    wide = FVSightParameters(grid=16, taxel_gain_spread=0.5, session_gain_drift=0.4)
    alive = [draws_living_factors(wide, number) for number in range(20)]
    assert set(alive) == {True, False}
    with pytest.raises(ValueError, match=r"unit .* draws a factor of -.* must be > 0: lower .*gain_spread"):
        [FVSightUnit(wide, number) for number in range(20)]
