"""Two methods on the same samples: difference, is it real, and are they equal for practical purposes.

The tests look at groups as the intervals do: Student's t on the linearised standard error; where too few groups
differ, Bonett and Price. With ten groups or more p is never smaller than what flipping the
signs of the groups that differ can give, 2^(1 - d).

References: Lakens, Social Psychological and Personality Science 8 (2017), two one-sided tests; Bonett and Price (2012).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr, stdtr

from leaderboard.groups import FloatArray, Groups
from leaderboard.statistics import FEW_GROUPS, Interval, bonett_price, difference_of, few_differ

MARGIN = 0.02
"""Two methods count as equivalent where they differ by surely less than two percentage points."""


@dataclass(frozen=True)
class Comparison:
    """`difference` is first minus second; `p` of no difference, `p_equivalent` of a difference beyond `margin`."""

    difference: Interval
    p: float
    p_equivalent: float
    margin: float


def compare_groups(a: Groups, b: Groups, margin: float = MARGIN, level: float = 0.95, seed: int = 0) -> Comparison:
    """Return the paired comparison of two methods from their sums over the same groups.

    ValueError when the groups are not the same, or the margin is not a share between 0 and 1.
    """
    if not 0 < margin < 1:
        raise ValueError(f"margin: expected a share between 0 and 1, got {margin:g}")
    d = a.minus(b)
    interval = difference_of(d, level, seed)
    above, below = one_sided(d, -margin), one_sided(d, margin)
    return Comparison(interval, difference_p(d), max(1 - above, below), margin)


def difference_p(d: Groups) -> float:
    """Return the two-sided p-value of a mean difference of zero."""
    under = one_sided(d, 0.0)
    p = min(1.0, 2 * min(under, 1 - under))
    if d.count >= FEW_GROUPS:
        p = max(p, 2.0 ** (1 - int((d.means != 0).sum())))
    return min(1.0, p)


def one_sided(d: Groups, at: float) -> float:
    """Return the probability of a mean as small as this one or smaller where the truth is `at`."""
    if few_differ(d):
        centre, error = bonett_price(d)
        return float(ndtr((centre - at) / error))
    error = d.standard_error
    return float(stdtr(d.count - 1, (d.mean - at) / error)) if error > 0 else float(d.mean > at)


def holm(p: ArrayLike) -> FloatArray:
    """Return Holm's step-down adjusted p-values (k,): reject where they are at most alpha, and all errors together
    stay below alpha. ValueError for anything but finite values in 0..1.

    Source: Holm, Scandinavian Journal of Statistics 6 (1979).
    """
    values = np.asarray(p, dtype=np.float64)
    if values.ndim != 1 or not np.all((values >= 0) & (values <= 1)):
        raise ValueError("holm: expected p-values between 0 and 1 in one dimension")
    order = np.argsort(values, kind="stable")
    steps = np.arange(len(values), 0, -1) * values[order]
    adjusted = np.empty_like(values)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(steps))
    return adjusted


@dataclass(frozen=True)
class Verdict:
    """What a family of comparisons lets one say of one of them: `word`, and the p-values after Holm's step-down."""

    word: Literal["first better", "second better", "equivalent", "undecided"]
    p: float
    p_equivalent: float


def verdicts(comparisons: Sequence[Comparison], level: float = 0.95) -> list[Verdict]:
    """Return the verdict on each of a family; equivalence wins over a difference that is real but below the margin."""
    different = holm([c.p for c in comparisons])
    equal = holm([c.p_equivalent for c in comparisons])
    made = []
    for c, p, q in zip(comparisons, different, equal, strict=True):
        word: Literal["first better", "second better", "equivalent", "undecided"] = "undecided"
        if q <= 1 - level:
            word = "equivalent"
        elif p <= 1 - level:
            word = "first better" if c.difference.value > 0 else "second better"
        made.append(Verdict(word, float(p), float(q)))
    return made
