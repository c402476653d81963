"""The sheet's transients lie inside what public recordings of Velostat show; its calibration undoes a long hold."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import curve_fit

from sensors.electronics.piezoresistive import PRESETS, PiezoresistiveChain

VELOSTAT = PRESETS["velostat"]


def resistance(force_n: float, hold_s: float = 4.0) -> np.ndarray:
    """R / R0 from a sudden press at 0 s; release at `hold_s`."""
    samples = round(hold_s * 1000)
    load = np.concatenate((np.zeros(1), np.full(samples, force_n), np.zeros(1500)))[:, None]
    conductance = VELOSTAT.conductance(VELOSTAT.respond(load))[:, 0]
    return conductance[0] / conductance[1:]


@pytest.mark.parametrize("force_n", [2.0, 5.0, 20.0, 45.0])
def test_transients_lie_in_the_ranges_of_recordings(force_n):
    history = resistance(force_n)
    assert 0.12 <= 1 - history[1000] / history[0] <= 0.25
    time = np.arange(1000) / 1000
    fitted, _ = curve_fit(
        lambda t, rest, drop, tau: rest + drop * np.exp(-t / tau), time, history[:1000], (0.8, 0.2, 0.3)
    )
    assert 0.26 <= fitted[2] <= 0.46
    assert 1.2 <= history[4000] <= 1.4
    assert 1.04 <= history[5000] <= 1.13


def test_conductance_is_a_power_of_the_load():
    force = np.geomspace(2, 50, 12)
    added = [1 / resistance(value)[1000] - 1 for value in force]
    assert 0.78 <= np.polyfit(np.log(force), np.log(added), 1)[0] <= 1.12


def test_presses_differ_by_tens_of_percent():
    rng = np.random.default_rng(0)
    load = np.full((200, 16), 5.0)
    means = np.array([VELOSTAT.read(load, rng).mean(axis=0) for _ in range(30)])
    assert 0.1 < (means.std(axis=0) / means.mean(axis=0)).mean() < 0.4


def test_a_sheet_long_under_its_load_reads_it_back():
    load = np.full((30000, 1), 5.0) * np.minimum(np.arange(30000) / 5000, 1)[:, None]
    assert VELOSTAT.read(load)[-1] == pytest.approx(5.0, rel=2e-3)


def test_a_released_sheet_has_no_remanence_and_a_loop_in_between():
    up = np.linspace(0, 50, 5001)[:, None]
    response = VELOSTAT.respond(np.concatenate((up, up[::-1])))[:, 0]
    assert response[-1] == 0
    assert (response[5001:][::-1] - response[:5001])[500:4500].min() > 0.05


def test_full_compensation_undoes_the_loop_that_the_loading_branch_leaves():
    up = np.linspace(0, 50, 501)[:, None]
    load = np.concatenate((up, up[::-1], up / 2))
    chain = PiezoresistiveChain(noise_v=0.0, adc_bits=24)
    static = np.abs(chain.read(load) - load).max()
    full = np.abs(replace(chain, compensate_hysteresis=True).read(load) - load).max()
    assert static > 0.1
    assert full < 1e-3


def test_what_has_no_inverse_or_no_meaning_is_refused():
    with pytest.raises(ValueError, match="without creep"):
        replace(VELOSTAT, compensate_hysteresis=True)
    with pytest.raises(ValueError, match="exponent"):
        PiezoresistiveChain(exponent=0.0)
    with pytest.raises(ValueError, match="adc_bits"):
        PiezoresistiveChain(adc_bits=0)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_loads_that_are_not_finite_are_refused(bad):
    with pytest.raises(ValueError, match="finite taxel loads"):
        VELOSTAT.read(np.full((3, 16), bad))
    with pytest.raises(ValueError, match="a chain needs"):
        PiezoresistiveChain(noise_v=bad)


def test_nothing_read_is_nothing():
    assert PiezoresistiveChain().read(np.zeros((0, 16))).shape == (0, 16)
