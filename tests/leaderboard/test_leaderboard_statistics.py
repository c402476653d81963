from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats

from leaderboard import statistics as st
from leaderboard.statistics import group_interval, paired_group_difference, wilson


@pytest.mark.parametrize(("k", "n"), [(0, 1), (1, 1), (0, 270), (270, 270), (267, 270), (1, 20), (19, 20), (50, 100)])
@pytest.mark.parametrize("level", [0.8, 0.95, 0.99])
def test_wilson_equals_scipy(k: int, n: int, level: float) -> None:
    reference = stats.binomtest(k, n).proportion_ci(level, method="wilson")
    np.testing.assert_allclose(wilson(k, n, level), (reference.low, reference.high), atol=1e-12)


def test_wilson_inverts_the_score_test() -> None:
    # At either end of the interval the score statistic of the observed share is exactly z.
    k, n, z = 33, 47, stats.norm.ppf(0.975)
    for end in wilson(k, n):
        assert abs(k / n - end) / np.sqrt(end * (1 - end) / n) == pytest.approx(z)


def test_wilson_is_symmetric_and_shrinks() -> None:
    low, high = wilson(30, 40)
    np.testing.assert_allclose(wilson(10, 40), (1 - high, 1 - low))
    widths = [np.ptp(wilson(0.9 * n, n)) for n in (10, 100, 1000)]
    assert widths == sorted(widths, reverse=True)


def test_wilson_takes_a_published_percentage() -> None:
    np.testing.assert_allclose(wilson(0.9889 * 270, 270), (0.968, 0.996), atol=1e-3)
    np.testing.assert_allclose(wilson(0.9531 * 270, 270), (0.921, 0.973), atol=1e-3)


@pytest.mark.parametrize(("k", "n", "level"), [(2, 1, 0.95), (-1, 5, 0.95), (0, 0, 0.95), (1, 2, 1.0), (1, 2, 0.0)])
def test_wilson_refuses(k: float, n: float, level: float) -> None:
    with pytest.raises(ValueError, match="expected"):
        wilson(k, n, level)


def _scores(seed: int, groups: int, size: int, p: float, spread: float) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    shape = 1 / spread - 1
    per_group = rng.beta(p * shape, (1 - p) * shape, groups)
    return rng.random((groups, size)).ravel() < np.repeat(per_group, size), np.repeat(np.arange(groups), size)


def test_few_groups_is_the_one_sample_t_interval() -> None:
    correct, groups = _scores(1, 6, 50, 0.7, 0.05)
    got = group_interval(correct, groups)
    reference = stats.ttest_1samp(correct.reshape(6, 50).mean(axis=1), 0.5).confidence_interval(0.95)
    assert got.method == st.STUDENT
    np.testing.assert_allclose((got.low, got.high), (reference.low, reference.high))
    assert (got.n, got.groups) == (300, 6)


def test_bootstrap_agrees_with_scipy_s_percentile_at_many_groups() -> None:
    correct, groups = _scores(2, 200, 5, 0.8, 0.1)
    got = group_interval(correct, groups)
    reference = stats.bootstrap(
        (correct.reshape(200, 5).mean(axis=1),), np.mean, method="percentile", n_resamples=5000, rng=0
    ).confidence_interval
    assert got.method == st.BOOTSTRAP
    np.testing.assert_allclose((got.low, got.high), (reference.low, reference.high), atol=3e-3)


def test_bootstrap_is_widened_to_t_at_ten_groups() -> None:
    correct, groups = _scores(3, 10, 200, 0.6, 0.05)
    got = group_interval(correct, groups)
    means = correct.reshape(10, 200).mean(axis=1)
    half = stats.t.ppf(0.975, 9) * means.std(ddof=1) / np.sqrt(10)
    assert got.high - got.low == pytest.approx(2 * half, rel=0.12)


def test_resampling_in_chunks_is_the_same_resampling(monkeypatch: pytest.MonkeyPatch) -> None:
    correct, groups = _scores(4, 40, 5, 0.8, 0.1)
    whole = group_interval(correct, groups, seed=7)
    monkeypatch.setattr(st, "_CHUNK", 999)
    assert group_interval(correct, groups, seed=7) == whole


def test_duplicated_frames_do_not_narrow_the_interval() -> None:
    correct, groups = _scores(5, 60, 4, 0.7, 0.2)
    once = group_interval(correct, groups)
    again = group_interval(np.repeat(correct, 30), np.repeat(groups, 30))
    np.testing.assert_allclose((again.low, again.high), (once.low, once.high))


def test_order_and_labels_of_groups_do_not_matter() -> None:
    correct, groups = _scores(6, 7, 20, 0.7, 0.1)
    order = np.random.default_rng(0).permutation(len(correct))
    names = np.array([f"unit-{g}" for g in groups])
    a, b = group_interval(correct, groups), group_interval(correct[order], names[order])
    np.testing.assert_allclose((a.low, a.high), (b.low, b.high))


def test_unequal_groups_are_centred_on_the_pooled_mean() -> None:
    sizes = [40, 40, 40, 40, 40, 8]
    groups = np.repeat(np.arange(6), sizes)
    correct = np.concatenate(
        [np.arange(n) < n * p for n, p in zip(sizes, (0.7, 0.6, 0.8, 0.7, 0.6, 0.25), strict=True)]
    )
    got = group_interval(correct, groups)
    assert got.value == pytest.approx(correct.mean())
    assert (got.low + got.high) / 2 == pytest.approx(correct.mean())


@pytest.mark.parametrize("count", [1, 2, 6, 300])
@pytest.mark.parametrize("value", [0.0, 1.0])
def test_perfect_groups_get_wilson_on_the_groups(count: int, value: float) -> None:
    got = group_interval(np.full(count * 4, value), np.repeat(np.arange(count), 4))
    assert got.method == st.WILSON_GROUPS
    np.testing.assert_allclose((got.low, got.high), wilson(value * count, count))
    assert got.high > got.low


def test_one_group_tells_almost_nothing() -> None:
    got = group_interval([0, 1] * 50, np.zeros(100))
    np.testing.assert_allclose((got.low, got.high), wilson(0.5, 1))


@pytest.mark.parametrize("count", [2, 3, 6, 40])
def test_groups_alike_but_not_perfect_keep_the_noise_of_their_samples(count: int) -> None:
    """Three units that each score exactly 1/27 must not get a zero width, nor the width of three coin flips."""
    correct = np.tile(np.arange(270) < 10, count)
    got = group_interval(correct, np.repeat(np.arange(count), 270))
    docked = 270 * count * (stats.norm.ppf(0.975) / stats.t.ppf(0.975, count - 1)) ** 2
    assert got.method == st.WILSON_EFFECTIVE
    np.testing.assert_allclose((got.low, got.high), wilson(docked / 27, docked))


@pytest.mark.parametrize("misses", [1, 2, 4])
def test_few_misses_among_single_samples_is_nearly_wilson(misses: int) -> None:
    correct = np.arange(270) >= misses
    got = group_interval(correct, np.arange(270))
    assert got.method == st.WILSON_EFFECTIVE
    np.testing.assert_allclose((got.low, got.high), wilson(270 - misses, 270), atol=1e-3)


def test_misses_within_one_group_cost_more_than_misses_spread() -> None:
    groups = np.repeat(np.arange(20), 10)
    together, apart = groups != 3, ~((np.arange(200) % 50) == 0)
    assert group_interval(together, groups).low < group_interval(apart, groups).low


def test_paired_difference_of_few_groups_is_the_paired_t_interval() -> None:
    a, groups = _scores(8, 6, 60, 0.8, 0.05)
    b, _ = _scores(9, 6, 60, 0.7, 0.05)
    got = paired_group_difference(a, b, groups)
    means = [x.reshape(6, 60).mean(axis=1) for x in (a, b)]
    reference = stats.ttest_rel(*means).confidence_interval(0.95)
    np.testing.assert_allclose((got.low, got.high), (reference.low, reference.high))


def test_paired_difference_is_antisymmetric() -> None:
    a, groups = _scores(10, 50, 5, 0.8, 0.1)
    b, _ = _scores(11, 50, 5, 0.7, 0.1)
    there, back = paired_group_difference(a, b, groups), paired_group_difference(b, a, groups)
    np.testing.assert_allclose((there.low, there.high), (-back.high, -back.low), atol=3e-3)


def test_pairing_removes_what_both_find_hard() -> None:
    hard = np.random.default_rng(0).random((40, 10)) < np.linspace(0.1, 0.9, 40)[:, None]
    better = hard.copy()
    better[::3, :3] = True
    groups = np.repeat(np.arange(40), 10)
    paired = paired_group_difference(better.ravel(), hard.ravel(), groups)
    alone = group_interval(hard.ravel(), groups)
    assert paired.method == alone.method == st.BOOTSTRAP
    assert paired.high - paired.low < (alone.high - alone.low) / 2


def test_equal_methods_differ_by_nothing_but_not_certainly() -> None:
    correct, groups = _scores(12, 30, 9, 0.8, 0.1)
    got = paired_group_difference(correct, correct, groups)
    assert got.method == st.BONETT_PRICE
    assert got.low < got.value == 0 < got.high
    assert got.low == pytest.approx(-got.high)


def test_bonett_price_worked_by_hand() -> None:
    a, b = np.ones(30), np.ones(30)
    b[:3] = 0  # 3 of 30 pairs favour a
    got = paired_group_difference(a, b, np.arange(30))
    up, down = 4 / 32, 1 / 32
    half = stats.norm.ppf(0.975) * np.sqrt((up + down - (up - down) ** 2) / 32)
    np.testing.assert_allclose((got.low, got.high), (up - down - half, up - down + half))


@pytest.mark.parametrize(
    ("correct", "groups", "message"),
    [
        ([], [], "at least one score"),
        ([1.0, np.nan], [0, 1], "finite scores"),
        ([0.0, 2.0], [0, 1], r"0\.\.1"),
        ([0, 1], [0], "one label a sample"),
        ([[0, 1]], [[0, 1]], "one dimension"),
    ],
)
def test_bad_scores_are_refused(correct: list[float], groups: list[int], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        group_interval(correct, groups)


def _coverage(
    repeats: int, groups: int, size: int, p: float, spread: float, interval: Callable[..., st.Interval]
) -> float:
    """Return the share of intervals that hold the true mean, in percent."""
    inside = 0
    for seed in range(repeats):
        got = interval(*_scores(seed, groups, size, p, spread))
        inside += got.low <= p <= got.high
    return 100 * inside / repeats


def _framewise(correct: np.ndarray, groups: np.ndarray) -> st.Interval:
    return group_interval(correct, np.arange(len(correct)))


def test_coverage_of_groups_and_of_frames() -> None:
    """By groups the interval covers what it says; frames taken as independent do not."""
    by_group = _coverage(250, 30, 20, 0.8, 0.2, group_interval)
    by_frame = _coverage(60, 30, 20, 0.8, 0.2, _framewise)
    assert by_group >= 91  # 250 repetitions: three standard errors below 95
    assert by_frame < 80


@pytest.mark.slow
@pytest.mark.parametrize(
    ("groups", "size", "p", "spread", "least"),
    [
        (12, 27, 0.8, 0.05, 92.5),
        (12, 27, 0.95, 0.02, 91),
        (54, 6, 0.8, 0.1, 92.5),
        (180, 2, 0.95, 0.1, 92.5),
        (180, 2, 0.99, 0.02, 92.5),
    ],
)
def test_coverage_at_the_group_counts_in_use(groups: int, size: int, p: float, spread: float, least: float) -> None:
    """Nominal 95 %; the last column is the floor. Near 100 % with few groups the interval covers a little less."""
    covered = _coverage(800, groups, size, p, spread, group_interval)
    print(f"{groups} groups of {size}, p {p}, spread {spread}: {covered:.1f} %")
    assert least <= covered <= 99.9


@pytest.mark.slow
@pytest.mark.parametrize(("groups", "size"), [(6, 270), (180, 2)])
def test_coverage_of_the_paired_difference(groups: int, size: int) -> None:
    inside = 0
    for seed in range(800):
        rng = np.random.default_rng(seed)
        base = rng.beta(16, 4, groups)[:, None]
        hard = rng.random((groups, size))
        a, b = hard < np.minimum(base + 0.05 * (1 - base), 1), hard < base * 0.95
        truth = 0.05 * 0.2 + 0.05 * 0.8
        got = paired_group_difference(a.ravel(), b.ravel(), np.repeat(np.arange(groups), size))
        inside += got.low <= truth <= got.high
    assert 92 <= inside / 8 <= 98.5
