"""Creep: its closed form on a hold and after release, rest, bounds, refusal of what has no meaning."""

import numpy as np
import pytest

from sensors.electronics.creep import Creep

RATE_HZ = 1000.0
CREEP = Creep((0.3, 2.0), (0.15, 0.08), closing_force_n=0.3)


def square_press(force_n: float, hold_s: float, after_s: float) -> np.ndarray:
    samples = round(hold_s * RATE_HZ), round(after_s * RATE_HZ)
    return np.concatenate((np.full(samples[0], force_n), np.zeros(samples[1])))[:, None]


def test_a_hold_and_a_release_follow_the_closed_form():
    force_n, hold_s = 4.0, 1.5
    factor = CREEP.factor(square_press(force_n, hold_s, 1.0), RATE_HZ)[:, 0]
    times, depths = np.array(CREEP.times_s), np.array(CREEP.depths)
    closed = force_n / (force_n + 0.3)
    held = np.arange(1500) / RATE_HZ
    since = np.arange(1000) / RATE_HZ
    on_hold = 1 - (depths * closed * np.exp(-held[:, None] / times)).sum(axis=1)
    memory = closed * (1 - np.exp(-hold_s / times))
    released = 1 - (depths * memory * np.exp(-since[:, None] / times)).sum(axis=1)
    assert factor[:1500] == pytest.approx(on_hold, abs=1e-12)
    assert factor[1500:] == pytest.approx(released, abs=1e-12)


def test_no_load_and_a_long_hold_leave_the_equilibrium():
    assert (CREEP.factor(np.zeros((50, 3)), RATE_HZ) == 1).all()
    assert CREEP.factor(np.full((40000, 1), 7.0), RATE_HZ)[-1] == pytest.approx(1, abs=1e-6)


def test_conductance_is_never_above_equilibrium_nor_below_the_depths():
    load = np.abs(np.cumsum(np.random.default_rng(0).normal(0, 0.5, (5000, 4)), axis=0))
    factor = CREEP.factor(load, RATE_HZ)
    assert (factor <= 1).all()
    assert (factor >= 1 - sum(CREEP.depths)).all()
    assert factor.min() < 0.95


def test_the_answer_does_not_depend_on_the_rate_of_sampling():
    load = square_press(5.0, 1.0, 1.0)
    assert CREEP.factor(load[::10], RATE_HZ / 10) == pytest.approx(CREEP.factor(load, RATE_HZ)[::10], abs=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"depths": (0.1,)}, "one depth for each time"),
        ({"times_s": (0.0, 1.0)}, "times_s > 0"),
        ({"closing_force_n": 0.0}, "closing_force_n > 0"),
        ({"depths": (0.6, 0.4)}, "sum to less than 1"),
        ({"depths": (-0.1, 0.4)}, "depths >= 0"),
    ],
)
def test_impossible_creep_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        Creep(**({"times_s": (0.3, 2.0), "depths": (0.1, 0.1), "closing_force_n": 0.3} | change))
