"""Play operators and their Prandtl-Ishlinskii sum."""

import numpy as np
import pytest

from sensors.electronics.hysteresis import PrandtlIshlinskii, play

HYSTERESIS = PrandtlIshlinskii((0.5, 2.0, 6.0, 15.0), (0.05, 0.04, 0.03, 0.02))


def play_by_loop(x: np.ndarray, threshold: float) -> np.ndarray:
    state, out = np.zeros(x.shape[1:]), np.empty_like(x)
    for t, value in enumerate(x):
        state = np.minimum(np.maximum(state, value - threshold), value + threshold)
        out[t] = state
    return out


@pytest.mark.parametrize("length", [1, 2, 3, 100, 1023])
def test_scan_equals_the_loop(length):
    x = np.random.default_rng(length).standard_normal((length, 3)).cumsum(axis=0)
    assert np.array_equal(play(x, 0.7), play_by_loop(x, 0.7))


def test_zero_threshold_is_the_identity():
    x = np.random.default_rng(0).standard_normal((50, 2))
    assert np.array_equal(play(x, 0.0), x)


def test_first_loading_follows_the_loading_branch():
    force = np.linspace(0, 50, 501)[:, None]
    assert HYSTERESIS.respond(force) == pytest.approx(HYSTERESIS.loading_branch(force), abs=1e-12)


def test_inverse_of_the_loading_branch_is_exact():
    force = np.concatenate((np.linspace(-20, 60, 400), [0.5, 2.0, 6.0, 15.0]))
    assert HYSTERESIS.invert_loading(HYSTERESIS.loading_branch(force)) == pytest.approx(force, abs=1e-12)


def test_unloading_lies_above_loading_and_the_loop_closes():
    up = np.linspace(0, 50, 501)
    force = np.concatenate((up, up[::-1], up))[:, None]
    response = HYSTERESIS.respond(force)[:, 0]
    loading, unloading, again = response[:501], response[501:1002][::-1], response[1002:]
    assert (unloading[50:-1] > loading[50:-1]).all()
    assert again[-1] == pytest.approx(loading[-1])


def test_response_does_not_depend_on_the_rate():
    slow = np.sin(np.linspace(0, 9, 2000))[:, None] * 10
    fast = slow[::7]
    assert HYSTERESIS.respond(slow)[::7] == pytest.approx(HYSTERESIS.respond(fast), abs=2e-2)


@pytest.mark.parametrize("bad", [((1.0,), (0.1, 0.2)), ((1.0,), (-0.1,)), ((1.0, 2.0), (0.6, 0.5)), ((-1.0,), (0.1,))])
def test_bad_weights_are_refused(bad):
    with pytest.raises(ValueError, match=r"thresholds|weights"):
        PrandtlIshlinskii(*bad)


def test_the_inverse_undoes_any_history():
    rng = np.random.default_rng(5)
    force = np.cumsum(rng.normal(0, 0.8, (3000, 4)), axis=0)
    assert HYSTERESIS.invert(HYSTERESIS.respond(force)) == pytest.approx(force, abs=1e-10)
    assert HYSTERESIS.respond(HYSTERESIS.invert(force)) == pytest.approx(force, abs=1e-10)
    assert np.abs(HYSTERESIS.respond(force) - force).max() > 0.1


def test_the_inverse_does_not_ask_for_an_order_of_thresholds():
    mixed = PrandtlIshlinskii((6.0, 0.5, 6.0, 0.0), (0.03, 0.05, 0.1, 0.2))
    force = np.cumsum(np.random.default_rng(6).normal(0, 1, (800, 2)), axis=0)
    assert mixed.invert(mixed.respond(force)) == pytest.approx(force, abs=1e-10)
