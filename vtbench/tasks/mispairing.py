"""Whose force, and of which moment, stands beside a frame when the two sensors are badly paired."""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vtbench.tasks.base import Features, NotPossibleError

WINDOW_S = 0.05
"""Force is averaged over this time where its moment is chosen."""

Rows = NDArray[np.int64]


def nearest_distance(pool: Rows, places_mm: NDArray[np.floating], distance_mm: float) -> Rows:
    """Partner (n,) of each sample: of its pool, never itself, the one whose distance is closest to `distance_mm`.

    Args:
        pool: (n,) number of the pool of each sample.
        places_mm: (n, 2) where the object lay.

    Raises:
        NotPossibleError: a sample is alone in its pool.
    """
    partner = np.empty(len(pool), np.int64)
    for members in _members(pool):
        apart = np.linalg.norm(places_mm[members, None] - places_mm[members], axis=2)
        miss = np.abs(apart - distance_mm)
        np.fill_diagonal(miss, np.inf)
        partner[members] = members[miss.argmin(1)]
    return partner


def another(pool: Rows, seed: int) -> Rows:
    """Partner (n,) of each sample: another one of its pool, at random.

    Raises:
        NotPossibleError: a sample is alone in its pool.
    """
    partner = np.empty(len(pool), np.int64)
    for number, members in enumerate(_members(pool)):
        rng = np.random.default_rng([seed, number])
        step = rng.integers(1, len(members), len(members))
        partner[members] = members[(np.arange(len(members)) + step) % len(members)]
    return partner


def of_another_class(pool: Rows, labels: NDArray[np.int64], seed: int) -> Rows:
    """Partner (n,) of each sample: one of its pool of another class, at random.

    Raises:
        NotPossibleError: a pool holds one class only.
    """
    partner = np.empty(len(pool), np.int64)
    for number, members in enumerate(_members(pool)):
        rng = np.random.default_rng([seed, number])
        for at in members:
            others = members[labels[members] != labels[at]]
            if not len(others):
                raise NotPossibleError("a sensor has presses of one object only: there is no other class to mix up")
            partner[at] = rng.choice(others)
    return partner


def clock_errors(ids: Sequence[str], most_s: float) -> NDArray[np.float64]:
    """Seconds (n,) by which the clocks of a sample differ: uniform within +- `most_s`, from its id alone."""
    drawn = [np.random.default_rng([zlib.crc32(str(name).encode()), 1]).uniform(-1, 1) for name in ids]
    return np.array(drawn) * most_s


def force_at(
    series: Sequence[NDArray[np.floating]], rate_hz: NDArray[np.floating], moments_s: NDArray[np.floating]
) -> Features:
    """Mean force (n, taxels) over `WINDOW_S` about a moment of each history, within what was recorded.

    Args:
        series: n histories (T, taxels) that begin at 0 s.
        rate_hz: (n,) samples a second.
        moments_s: (n,).
    """
    rows = []
    for each, rate, moment in zip(series, rate_hz, moments_s, strict=True):
        width = min(max(1, round(WINDOW_S * rate)), len(each))
        start = int(np.clip(round(moment * rate - width / 2), 0, len(each) - width))
        rows.append(each[start : start + width].mean(0))
    return np.array(rows, np.float32)


def late(
    series: Sequence[NDArray[np.floating]], rate_hz: NDArray[np.floating], errors_s: NDArray[np.floating]
) -> list[NDArray[np.floating]]:
    """Histories as a clock that is off by `errors_s` reads them: sample t is that of t + error, held at the ends.

    Args:
        series: n histories (T, taxels).
        rate_hz: (n,) samples a second.
        errors_s: (n,).
    """
    shifts = np.round(rate_hz * errors_s).astype(np.int64)
    return [each[np.clip(np.arange(len(each)) + by, 0, len(each) - 1)] for each, by in zip(series, shifts, strict=True)]


def _members(pool: Rows) -> list[Rows]:
    groups = [np.flatnonzero(pool == number) for number in np.unique(pool)]
    if any(len(members) < 2 for members in groups):
        raise NotPossibleError(
            "an object has one press only in a half of a sensor's presses: there is no other to take"
        )
    return groups
