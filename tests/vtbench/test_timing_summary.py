"""What a timing says: medians over processes, their interval, an order that is fair to all."""

import numpy as np
import pytest

from vtbench.timing.child import measure
from vtbench.timing.schedule import order
from vtbench.timing.summary import figure, median_interval, ratio_interval


def test_a_slow_call_moves_no_process_and_a_slow_process_no_figure():
    steady = [[1000] * 9 + [90_000] for _ in range(9)]
    assert figure(steady, 1).value == 1.0
    assert figure([*steady, [50_000] * 10], 1).value == 1.0
    assert figure(steady, 1).least == 1.0


def test_a_batch_is_counted_by_the_sample():
    one, hundred = figure([[1000, 2000, 3000]] * 3, 1), figure([[1000, 2000, 3000]] * 3, 100)
    assert one.value == pytest.approx(100 * hundred.value)
    assert one.p95 == pytest.approx(100 * hundred.p95)


@pytest.mark.parametrize("processes", [6, 10, 11, 20, 30])
def test_the_interval_holds_the_true_median_as_often_as_it_says(processes):
    rng = np.random.default_rng(processes)
    intervals = [median_interval(values) for values in rng.lognormal(0.0, 0.1, (4000, processes))]
    assert 0.935 <= np.mean([low <= 1.0 <= high for low, high in intervals]) <= 0.97


def test_of_few_processes_the_interval_is_their_range():
    assert median_interval([3.0, 1.0, 2.0]) == (1.0, 3.0)
    assert median_interval([2.0]) == (2.0, 2.0)


def test_two_copies_of_one_thing_are_seldom_told_apart():
    """The control of a timing: at most ten of a hundred, with drift over the rounds that falls on both."""
    rng = np.random.default_rng(1)
    apart = 0
    for _ in range(100):
        drift = np.linspace(1.0, 1.2, 10)
        a, b = drift * rng.lognormal(0, 0.03, (2, 10))
        _, low, high = ratio_interval(a, b)
        apart += not low <= 1 <= high
    assert apart <= 10


def test_what_is_twice_as_slow_is_seen_through_noise_and_drift():
    rng = np.random.default_rng(2)
    drift = np.linspace(1.0, 1.5, 10)
    ratio, low, high = ratio_interval(2 * drift * rng.lognormal(0, 0.03, 10), drift * rng.lognormal(0, 0.03, 10))
    assert low <= ratio <= high
    assert low > 1.8
    assert high < 2.2


def test_every_round_holds_every_subject_once_in_another_order():
    steps = list(order(6, 10))
    rounds = [[at for number, at in steps if number == wanted] for wanted in range(10)]
    assert all(sorted(each) == list(range(6)) for each in rounds)
    assert len({tuple(each) for each in rounds}) > 5
    assert steps == list(order(6, 10))


def test_calls_rotate_through_the_samples_and_end_at_the_count():
    seen = []
    taken = measure(seen.append, 3, 7, 100.0)
    assert seen == [0, 1, 2, 0, 1, 2, 0]
    assert len(taken) == 7
    assert min(taken) >= 0
