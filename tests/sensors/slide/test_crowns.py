"""Thread crowns: nothing without slip, the sum kept, the strength that was asked for at any resolution."""

import numpy as np
import pytest

from sensors.slide.crowns import Crowns

PITCH = 0.7e-3


def draw(cells=50, area=PITCH**2, contrast=0.2, seed=0):
    return Crowns.draw(np.full(cells, area), contrast, PITCH, np.random.default_rng(seed))


def test_load_depends_on_the_distance_slid_alone():
    crowns, load = draw(), np.random.default_rng(1).random(50)
    slip = np.zeros((50, 2))
    at_rest = crowns.exchange(load, slip)
    assert np.array_equal(at_rest, crowns.exchange(load, slip))
    there = crowns.exchange(load, slip + np.array([1e-4, 0]))
    assert not np.allclose(there, at_rest)
    assert crowns.exchange(load, slip) == pytest.approx(at_rest)


def test_the_sum_of_the_load_is_kept():
    crowns, rng = draw(contrast=0.8), np.random.default_rng(2)
    for _ in range(20):
        load = rng.random(50) * (rng.random(50) > 0.3)
        changed = crowns.exchange(load, rng.normal(0, 1e-3, (50, 2)))
        assert changed.sum() == pytest.approx(load.sum())
        assert (changed >= 0).all()
        assert (changed[load == 0] == 0).all()
    assert (crowns.exchange(np.zeros(50), np.zeros((50, 2))) == 0).all()


@pytest.mark.parametrize("crowns_per_cell", [1, 4])
def test_a_cell_varies_by_the_contrast_over_the_root_of_its_crowns(crowns_per_cell):
    # many cells, so that keeping the sum takes little away
    crowns = draw(cells=400, area=crowns_per_cell * PITCH**2)
    load = np.ones(400)
    slips = np.linspace(0, 20e-3, 200)
    history = np.array([crowns.exchange(load, np.tile([s, 0.3 * s], (400, 1))) for s in slips])
    assert history.std() == pytest.approx(0.2 / np.sqrt(crowns_per_cell), rel=0.1)


def test_the_weave_is_heard_at_its_own_pitch():
    crowns = draw(cells=200)
    slips = np.arange(0, 64 * PITCH, PITCH / 16)
    history = np.array([crowns.exchange(np.ones(200), np.tile([s, 0.0], (200, 1))) for s in slips])
    power = (np.abs(np.fft.rfft(history - history.mean(axis=0), axis=0)) ** 2).mean(axis=1)
    assert power.argmax() == 64
