"""Where a nominal 95 % interval covers noticeably more or less: the warning that stands beside it.

The bounds come from `python -m leaderboard.coverage`: groups of unlike difficulty, at the group counts in use.
"""

from __future__ import annotations

from leaderboard.statistics import BONETT_PRICE, FEW_GROUPS, WILSON_EFFECTIVE, WILSON_GROUPS

MARK = "≈"
"""Stands before an interval that carries a warning."""
MANY_GROUPS, SOME_GROUPS = 100, 20
NEAR = 0.9
"""Beyond this share (or below one minus it) few groups see too few misses."""

FEW = "fewer than ten groups: where groups differ much, nominal 95 % covers as little as 83 %"
EDGE = "fewer than a hundred groups near 0 or 100 %: nominal 95 % covers 88 to 100 %, by how much groups differ"
WIDE = "hardly any group differs, so the interval leans to the safe side: nominal 95 % covers 97 to 100 %"

FEW_AND_UNEVEN = "fewer than ten groups: where a difference sits in few of them, nominal 95 % covers as little as 76 %"
SOME = "fewer than twenty groups: where groups differ much, nominal 95 % covers 92 %"
UNEVEN = "fewer than a hundred groups: where a difference sits in few of them, nominal 95 % covers 92 %"


def coverage_warning(method: str, groups: int, value: float, *, difference: bool = False) -> str:
    """Return why the interval of a share, or of a difference of shares, may not cover what it says, or nothing.

    `method` is the name that `Interval.method` gives, `value` the estimate.
    """
    if not method:
        return ""
    if groups < FEW_GROUPS:
        return FEW_AND_UNEVEN if difference else FEW
    if not difference and groups < MANY_GROUPS and not 1 - NEAR <= value <= NEAR:
        return EDGE
    if method in (WILSON_EFFECTIVE, WILSON_GROUPS, BONETT_PRICE):
        return WIDE
    if not difference and groups < SOME_GROUPS:
        return SOME
    return UNEVEN if difference and groups < MANY_GROUPS else ""
