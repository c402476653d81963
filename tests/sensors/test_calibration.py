"""The calibration experiments measure what they name: known chains give known figures."""

from dataclasses import replace

import numpy as np
import pytest

from sensors.calibration import (
    TOP_N,
    VELOSTAT_RANGES,
    hold_and_release,
    loading_loop,
    scan_errors,
    static_table,
    transient_measures,
    weigh,
)
from sensors.electronics.hysteresis import PrandtlIshlinskii
from sensors.electronics.piezoresistive import PRESETS, PiezoresistiveChain

SLOW = PiezoresistiveChain(rate_hz=100.0, noise_v=0.0)


def table(chain, gain=None, seed=0):
    rng = np.random.default_rng(seed)
    readings = weigh(chain, np.ones(16) if gain is None else gain, rng)
    rows = static_table(chain, loading_loop(chain, rng), readings, rng)
    return {row["quantity"]: row["value"] for row in rows}


def test_the_loop_is_50_newtons_at_one_newton_a_second():
    loop = loading_loop(SLOW)
    assert loop.load_n.max() == TOP_N
    assert np.abs(np.diff(loop.load_n) / np.diff(loop.time_s)) == pytest.approx(1.0)
    assert loop.load_n[[0, -1]] == pytest.approx(0)


def test_the_gap_of_one_play_is_twice_its_weight_times_its_threshold():
    chain = replace(SLOW, hysteresis=PrandtlIshlinskii((5.0,), (0.1,)), adc_bits=24)
    # read back through the loading branch the gap keeps its size where that branch has slope one
    assert table(chain)["hysteresis"] == pytest.approx(100 * 2 * 0.1 * 5.0 / TOP_N, rel=0.01)
    assert table(replace(chain, hysteresis=None))["hysteresis"] < 1e-3


def test_spread_is_that_of_the_gains_and_resolution_that_of_the_noise():
    gain = 1 + 0.06 * np.random.default_rng(1).standard_normal(16)
    found = table(replace(SLOW, noise_v=1e-3), gain)
    assert found["spread at 100 g"] == pytest.approx(100 * (gain ** (1 / 0.9)).std(ddof=1), rel=0.05)
    slope = np.gradient(SLOW.voltage(np.array([19.9, 20.0, 20.1])), 0.1)[1]
    assert found["resolution at 20 N"] == pytest.approx(3 * 1e-3 / slope, rel=0.1)
    assert found["accuracy"] < 0.25


def test_velostat_lies_in_every_range_and_fvsight_does_not_creep():
    measured = transient_measures(PRESETS["velostat"], np.random.default_rng(0))
    assert all(VELOSTAT_RANGES[name][0] <= value <= VELOSTAT_RANGES[name][1] for name, value in measured.items())
    _, ratio = hold_and_release(PRESETS["fvsight"], 5.0, 1.0, 0.5)
    assert np.ptp(ratio[300:1100]) == pytest.approx(0, abs=1e-12)
    still = transient_measures(PRESETS["fvsight"], np.random.default_rng(0))
    assert still["fall of R in the first second of a hold (%)"] == 0


def test_only_floating_and_uncorrected_scans_have_ghosts():
    errors = {row["scan"]: row["rms_n"] for row in scan_errors(SLOW, np.random.default_rng(0))}
    assert errors["isolated"] < 1e-3
    assert errors["rows grounded, corrected"] < 1e-3
    assert errors["rows grounded, as read"] > 0.5
    assert errors["rows floating"] > 0.5


def test_the_seed_decides_every_figure():
    noisy = replace(PRESETS["velostat"], rate_hz=100.0)
    assert table(noisy, seed=2) == table(noisy, seed=2)
    assert table(noisy, seed=2) != table(noisy, seed=3)
