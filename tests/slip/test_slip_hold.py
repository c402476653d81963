import numpy as np
import pytest

from slip.hold import HoldOn, hold_on


@pytest.mark.parametrize(("periods", "release"), [(1, 1), (3, 1), (3, 4), (1, 5)])
def test_stream_and_batch_hold_alike(periods, release):
    flags = np.random.default_rng(periods + release).uniform(size=2000) < 0.6
    stream = HoldOn(periods, release)
    np.testing.assert_array_equal(hold_on(flags, periods, release), [stream.update(bool(f)) for f in flags])


def test_one_period_and_one_release_change_nothing():
    flags = np.random.default_rng(0).uniform(size=200) < 0.5
    np.testing.assert_array_equal(hold_on(flags, 1), flags)


def test_slip_begins_after_the_periods_and_gaps_below_release_are_bridged():
    flags = np.array([0, 1, 1, 0, 1, 1, 1, 0, 1, 0, 0, 1], dtype=bool)
    np.testing.assert_array_equal(np.flatnonzero(hold_on(flags, 3)), [6])
    np.testing.assert_array_equal(np.flatnonzero(hold_on(flags, 3, release=2)), [6, 7, 8, 9])


def test_reset_ends_the_slip():
    hold = HoldOn(1, 10)
    assert hold.update(True)
    hold.reset()
    assert not hold.update(False)


@pytest.mark.parametrize(("periods", "release"), [(0, 1), (1, 0), (1.5, 1), (True, 1)])
def test_periods_are_whole_and_positive(periods, release):
    with pytest.raises(ValueError, match="whole number"):
        hold_on(np.zeros(3, dtype=bool), periods, release)


def test_no_samples_hold_nothing():
    assert hold_on(np.zeros(0, dtype=bool), 3).shape == (0,)
