"""The chain from load to read-back force."""

from dataclasses import replace

import numpy as np
import pytest

from sensors.electronics.piezoresistive import PiezoresistiveChain

CHAIN = PiezoresistiveChain()


def ramp(top_n: float = 50.0) -> np.ndarray:
    return np.linspace(0, top_n, 501)[:, None] * np.ones(16)


def test_divider_is_the_papers_formula():
    resistance = 1 / (CHAIN.rest_conductance_s + CHAIN.conductance_coefficient * 8.0**CHAIN.exponent)
    expected = 3.3 * 10e3 / (resistance + 10e3)
    assert CHAIN.voltage(np.array([8.0]))[0] == pytest.approx(expected, rel=1e-12)


def test_half_the_supply_at_midscale():
    assert CHAIN.voltage(np.array([CHAIN.midscale_force_n]))[0] == pytest.approx(3.3 / 2, rel=5e-3)


def test_noise_free_loading_reads_back_within_an_adc_step():
    load = ramp()
    error = np.abs(CHAIN.read(load) - load)
    step_n = 3.3 / 2**16 / np.gradient(CHAIN.voltage(load[:, 0]), load[:, 0])[:, None]
    assert (error <= step_n).all()


def test_read_back_keeps_the_stated_accuracy_on_loading_and_unloading():
    load = np.concatenate((ramp(), ramp()[::-1]))
    read = CHAIN.read(load, np.random.default_rng(0))
    root_mean_square = np.sqrt(((read - load) ** 2).mean(axis=1))
    assert (root_mean_square <= np.maximum(0.2, 0.05 * load[:, 0])).all()


def test_weights_read_equal_on_every_taxel_and_to_their_mass():
    for grams in (20, 50, 100, 200):
        load = np.full((400, 16), grams * 1e-3 * 9.81)
        read = CHAIN.read(load, np.random.default_rng(grams)).mean(axis=0)
        assert read == pytest.approx(load[0], abs=0.02)


def test_hysteresis_off_makes_the_chain_memoryless():
    plain = replace(CHAIN, hysteresis=None)
    load = np.concatenate((ramp(), ramp()[::-1]))
    read = plain.read(load)
    assert read[:501] == pytest.approx(read[501:][::-1], abs=1e-12)


def test_a_stiffer_taxel_reads_low():
    load = ramp(10.0)
    low = CHAIN.read(load, None, gain=0.9)
    assert (low[50:] < load[50:]).all()


def test_readings_saturate_instead_of_overflowing():
    read = CHAIN.read(np.full((3, 16), 1e9))
    assert np.isfinite(read).all()


def test_reading_is_monotone_in_the_load():
    assert (np.diff(CHAIN.read(ramp())[:, 0]) >= 0).all()
