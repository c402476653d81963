"""Intervals for scores: Wilson for independent trials, resampling over groups for everything else.

A group is what repeats when the experiment is repeated: a press when the same press is tested in several
draws, a sensor unit when units are held out. Frames of one press are never treated as independent trials.

References: Wilson, JASA 22 (1927); Hesterberg, The American Statistician 69 (2015), on the expanded percentile
interval; Bonett and Price, British Journal of Mathematical and Statistical Psychology 65 (2012).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr, ndtri, stdtrit

from leaderboard.groups import FloatArray, Groups, grouped

WILSON = "Wilson"
BOOTSTRAP = "bootstrap over groups, expanded percentile"
STUDENT = "Student t over groups"
WILSON_EFFECTIVE = "Wilson on the effective sample size (too few groups differ to resample)"
WILSON_GROUPS = "Wilson on the number of groups (all groups perfect, or all zero)"
BONETT_PRICE = "Bonett-Price on the number of groups (too few differ to resample)"

FEW_GROUPS = 10  # below this a bootstrap has too few distinct resamples; Student t takes over
FEW_DIFFERING = 5  # with fewer groups off the common value, resampling does not see the tail
RESAMPLES = 4000
_CHUNK = 4_000_000  # drawn groups held in memory at a time


@dataclass(frozen=True)
class Interval:
    """An estimate with its interval, how it was made, and from how many samples and groups."""

    value: float
    low: float
    high: float
    level: float
    method: str
    n: int
    groups: int


def wilson(k: float, n: float, level: float = 0.95) -> tuple[float, float]:
    """Return Wilson's score interval (low, high) for k successes in n independent trials.

    `k` need not be whole: a published percentage of an assumed n is often not. ValueError unless 0 <= k <= n, n > 0.
    """
    _check_level(level)
    if not (n > 0 and 0 <= k <= n):
        raise ValueError(f"wilson: expected 0 <= k <= n and n > 0, got k = {k}, n = {n}")
    z = float(ndtri(0.5 + level / 2))
    p = k / n
    scale = 1 + z * z / n
    centre = (p + z * z / (2 * n)) / scale
    half = z * sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / scale
    low = 0.0 if k == 0 else max(0.0, centre - half)
    high = 1.0 if k == n else min(1.0, centre + half)
    return low, high


def group_interval(correct: ArrayLike, groups: ArrayLike, level: float = 0.95, seed: int = 0) -> Interval:
    """Return the mean score with an interval that treats groups, not samples, as the independent trials.

    `correct` (n,) holds scores in 0..1 (bool or float), `groups` (n,) a label each (any sortable dtype).
    Ten groups or more: percentile bootstrap over groups, widened for small counts (expanded percentile).
    Fewer: Student t over groups. Where fewer than five groups differ from perfect (or from zero), or all are alike,
    Wilson on the effective sample size; where all are perfect or all zero, or there is one, Wilson on the number of
    groups. So no interval has zero width.
    With few groups, very unequal groups and a score near 100 % the Student interval covers less than it says.
    ValueError when there is nothing to score, a score is outside 0..1 or not finite, or lengths differ.
    """
    _check_level(level)
    return interval_of(grouped(_scores(correct, "correct", 0.0, 1.0), groups), level, seed)


def interval_of(g: Groups, level: float = 0.95, seed: int = 0) -> Interval:
    """Return `group_interval` from the sums of the groups alone."""
    _check_level(level)
    p = min(max(g.mean, 0.0), 1.0)
    means = g.means
    differing = min(int((means < 1).sum()), int((means > 0).sum()))
    if differing == 0 or g.count == 1:
        low, high = wilson(p * g.count, g.count, level)
        return Interval(p, low, high, level, WILSON_GROUPS, g.n, g.count)
    if differing < min(FEW_DIFFERING, g.count) or np.ptp(means) <= 1e-12:
        n_effective = _effective_size(g, level)
        low, high = wilson(p * n_effective, n_effective, level)
        method = WILSON_EFFECTIVE
    else:
        low, high, method = _resampled(g, level, seed)
    return Interval(p, max(0.0, low), min(1.0, high), level, method, g.n, g.count)


def paired_group_difference(
    correct_a: ArrayLike, correct_b: ArrayLike, groups: ArrayLike, level: float = 0.95, seed: int = 0
) -> Interval:
    """Return the mean of `correct_a - correct_b` on the same samples with an interval over groups.

    All three are (n,), aligned sample by sample. Pairing removes what both methods find hard alike. Method as in
    `group_interval`; where fewer than five of ten groups or more differ, or all by the same, Bonett-Price. ValueError
    as there.
    """
    _check_level(level)
    a, b = _scores(correct_a, "correct_a", 0.0, 1.0), _scores(correct_b, "correct_b", 0.0, 1.0)
    if len(a) != len(b):
        raise ValueError(f"paired difference: expected scores of the same samples, got {len(a)} and {len(b)}")
    return difference_of(grouped(a - b, groups), level, seed)


def difference_of(g: Groups, level: float = 0.95, seed: int = 0) -> Interval:
    """Return `paired_group_difference` from the groups' sums of differences alone."""
    _check_level(level)
    if few_differ(g):
        centre, error = bonett_price(g)
        half = float(ndtri(0.5 + level / 2)) * error
        low, high, method = min(centre - half, g.mean), max(centre + half, g.mean), BONETT_PRICE
    else:
        low, high, method = _resampled(g, level, seed)
    return Interval(g.mean, max(-1.0, low), min(1.0, high), level, method, g.n, g.count)


def few_differ(g: Groups) -> bool:
    """Whether too few groups show a difference (of few groups: whether all show the same one) to read their spread."""
    alike = bool(np.ptp(g.means) <= 1e-12)
    return alike or (g.count >= FEW_GROUPS and int((g.means != 0).sum()) < FEW_DIFFERING)


def _resampled(g: Groups, level: float, seed: int) -> tuple[float, float, str]:
    t = float(stdtrit(g.count - 1, 0.5 + level / 2))
    if g.count < FEW_GROUPS:
        half = t * g.standard_error
        return g.mean - half, g.mean + half, STUDENT
    # Hesterberg's correction: the plain percentile interval is too narrow by sqrt((g - 1) / g) * z / t.
    tail = float(ndtr(-sqrt(g.count / (g.count - 1)) * t))
    low, high = np.quantile(_bootstrap_means(g, seed), [tail, 1 - tail])
    return float(low), float(high), BOOTSTRAP


def _bootstrap_means(g: Groups, seed: int) -> FloatArray:
    """Return (RESAMPLES,) pooled means of groups drawn with replacement."""
    rng = np.random.default_rng(seed)
    step = max(1, _CHUNK // g.count)
    parts = []
    for start in range(0, RESAMPLES, step):
        draws = min(step, RESAMPLES - start)
        drawn = rng.integers(0, g.count, size=(draws, g.count), dtype=np.uint32)
        parts.append(g.total[drawn].sum(axis=1) / g.size[drawn].sum(axis=1))
    return np.concatenate(parts)


def _effective_size(g: Groups, level: float) -> float:
    """Return the number of independent trials with this standard error, docked for the groups being few."""
    p = g.mean
    variance, samples = p * (1 - p), float(g.size.sum())
    n = samples if variance >= samples * g.standard_error**2 else variance / g.standard_error**2
    z, t = float(ndtri(0.5 + level / 2)), float(stdtrit(g.count - 1, 0.5 + level / 2))
    return max(1.0, n * (z / t) ** 2)


def bonett_price(g: Groups) -> tuple[float, float]:
    """Return centre and standard error of Bonett and Price's difference of paired proportions, groups as trials.

    Samples may not stand in for few groups that show no difference: the next group may be the one that does.
    """
    trials = g.count + 2
    up = (float(g.means[g.means > 0].sum()) + 1) / trials
    down = (float(-g.means[g.means < 0].sum()) + 1) / trials
    return up - down, sqrt((up + down - (up - down) ** 2) / trials)


def _scores(values: ArrayLike, name: str, low: float, high: float) -> FloatArray:
    scores = np.asarray(values, dtype=np.float64)
    if scores.ndim != 1 or not len(scores):
        raise ValueError(f"{name}: expected at least one score in one dimension, got shape {scores.shape}")
    if not np.all((scores >= low) & (scores <= high)):
        raise ValueError(f"{name}: expected finite scores in {low:g}..{high:g}, got others")
    return scores


def _check_level(level: float) -> None:
    if not 0 < level < 1:
        raise ValueError(f"level: expected a probability between 0 and 1, got {level}")
