"""The capacitive chain: plates, rest, its inverse, first-order lag, slow whole counts."""

from dataclasses import replace

import numpy as np
import pytest

from sensors.electronics.capacitive import CapacitiveChain

CHAIN = CapacitiveChain()
QUIET = np.random.default_rng(0)


def test_counts_are_the_relative_change_of_a_plate_capacitor():
    load = np.array([0.0, 0.3, 4.0, 50.0])
    gap = 1 - 0.5 * load / (load + 4.0)
    assert CHAIN.counts(load) == pytest.approx(4800.0 * (1 / gap - 1))


def test_no_load_reads_zero_and_pulling_too():
    _, counts = CHAIN.read(np.zeros((200, 16)), 1000.0)
    assert (counts == 0).all()
    assert (CHAIN.counts(np.array([-3.0])) == 0).all()


def test_static_counts_give_back_the_load():
    load = np.linspace(0, 30, 100)
    assert CHAIN.load(CHAIN.counts(load)) == pytest.approx(load, abs=1e-9)
    _, counts = CHAIN.read(np.full((500, 4), 2.0), 1000.0, settled=True)
    assert CHAIN.load(counts.astype(float)) == pytest.approx(2.0, abs=2e-3)


def test_samples_come_every_28_ms_and_are_whole_counts():
    time, counts = CHAIN.read(np.ones((2800, 16)), 1000.0, np.random.default_rng(0))
    assert np.diff(time) == pytest.approx(0.028)
    assert counts.shape == (100, 16)
    assert (counts == np.rint(counts)).all()


def test_a_step_rises_with_the_time_of_the_bandwidth():
    chain = replace(CHAIN, rest_counts=1e8, top_counts=1e9, period_ms=1.0)
    time, counts = chain.read(np.full((1000, 1), 1.0), 1000.0)
    risen = counts[:, 0] / chain.counts(np.array([1.0]))
    assert risen == pytest.approx(1 - np.exp(-2 * np.pi * 5.0 * (time + 1e-3)), abs=1e-6)


def test_fast_ripples_fade_and_slow_ones_pass():
    time = np.arange(0, 8, 1e-3)
    spread = {}
    for frequency in (0.3, 50.0):
        load = 1 + 0.2 * np.sin(2 * np.pi * frequency * time)[:, None]
        _, counts = CHAIN.read(load, 1000.0, settled=True)
        spread[frequency] = counts.std()
    assert spread[50.0] < 0.15 * spread[0.3]


def test_noise_is_about_a_count():
    _, counts = CHAIN.read(np.ones((28000, 16)), 1000.0, np.random.default_rng(1), settled=True)
    assert counts.std(axis=0).mean() == pytest.approx(1.0, abs=0.1)


def test_impossible_chains_and_clocks_are_refused():
    with pytest.raises(ValueError, match="or faster, got rate_hz=20"):
        CHAIN.read(np.ones((10, 4)), 20.0)
    with pytest.raises(ValueError, match="full_squeeze"):
        CapacitiveChain(full_squeeze=1.0)
    with pytest.raises(ValueError, match="noise_counts"):
        CapacitiveChain(noise_counts=-1.0)
    with pytest.raises(ValueError, match="finite taxel loads"):
        CHAIN.read(np.full((10, 4), np.nan), 1000.0)
