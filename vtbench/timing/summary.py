"""Samples of processes -> a figure with an interval: the median of the process medians.

Calls of one process share its memory layout and its moment; processes are what repeats. The interval interpolates
between order statistics (Hettmansperger and Sheather, Statistics and Probability Letters 4, 1986); a percentile
bootstrap of the median of ten processes covers 91 % where it says 95.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import comb
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

LEVEL = 0.95


@dataclass(frozen=True)
class Figure:
    """Microseconds a sample: median of process medians with its interval, least call and 95th percentile."""

    value: float
    low: float
    high: float
    least: float
    p95: float


@dataclass(frozen=True)
class Cost:
    """What a subject costs over its processes.

    Attributes:
        one, many: a sample alone and in the large batch, microseconds a sample.
        import_s, load_s: medians, seconds.
        first_us: median of the first call of a process.
        peak_mb: median of the processes' largest resident memory.
        params, macs, bytes: of its graph, alike on any machine; None where it has none, or where none was counted.
    """

    one: Figure
    many: Figure
    large: int
    processes: int
    import_s: float
    load_s: float
    first_us: float
    peak_mb: float
    params: int | None = None
    macs: int | None = None
    bytes: int | None = None


def cost(samples: Sequence[dict[str, Any]]) -> Cost:
    """Cost from the samples of each process, as `vtbench.timing.child` prints them."""
    large = int(samples[0]["large"])
    graph: dict[str, int | None] = next((each["graph"] for each in samples if each.get("graph")), {})
    return Cost(
        figure([sample["one_ns"] for sample in samples], 1),
        figure([sample["many_ns"] for sample in samples], large),
        large,
        len(samples),
        _median(samples, "import_s"),
        _median(samples, "load_s"),
        _median(samples, "first_call_ns") / 1e3,
        _median(samples, "peak_mb"),
        **{name: graph.get(name) for name in ("params", "macs", "bytes")},
    )


def _median(samples: Sequence[dict[str, Any]], name: str) -> float:
    return float(np.median([sample[name] for sample in samples]))


def figure(calls_ns: Sequence[Sequence[int]], per: int) -> Figure:
    """Figure of processes' calls, each doing `per` samples, nanoseconds."""
    medians = np.array([np.median(calls) for calls in calls_ns]) / per / 1e3
    every = np.concatenate([np.asarray(calls, np.float64) for calls in calls_ns]) / per / 1e3
    low, high = median_interval(medians)
    return Figure(float(np.median(medians)), low, high, float(every.min()), float(np.percentile(every, 95)))


def median_interval(values: ArrayLike, level: float = LEVEL) -> tuple[float, float]:
    """Interval of the median of independent values (n,), whatever their distribution.

    Of fewer than six no order statistics reach 95 %: their range, which covers 1 - 2^(1 - n).
    """
    ordered = np.sort(np.asarray(values, np.float64))
    n = len(ordered)
    k, share = _order_statistics(n, level)
    if n == 1:
        return float(ordered[0]), float(ordered[0])
    steps = ((k - 1, 1), (n - k, -1))
    low, high = (ordered[at] + share * (ordered[at + step] - ordered[at]) for at, step in steps)
    return float(low), float(high)


@cache
def _order_statistics(n: int, level: float) -> tuple[int, float]:
    """The k-th smallest of n begins the interval, moved by a share of the way to the next."""
    inside = [1 - 2 * sum(comb(n, i) for i in range(k)) / 2**n for k in range(1, n // 2 + 1)]
    k = sum(each >= level for each in inside)
    if k == 0:
        return 1, 0.0
    beyond = inside[k] if k < len(inside) else 0.0
    part = (inside[k - 1] - level) / (inside[k - 1] - beyond)
    return k, (n - k) * part / (k + (n - 2 * k) * part)


def ratio_interval(a: ArrayLike, b: ArrayLike) -> tuple[float, float, float]:
    """Median over rounds of a / b (rounds,) with its interval: what slowed a round falls on both."""
    ratios = np.asarray(a, np.float64) / np.asarray(b, np.float64)
    return float(np.median(ratios)), *median_interval(ratios)
