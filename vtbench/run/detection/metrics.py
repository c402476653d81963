"""Shares, rates and delays as metrics, each with its 95 % interval over trials."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import Metric
from leaderboard.slips import MISSED_MS
from leaderboard.statistics import WILSON, wilson
from slip.alarms import EXPECTED_FALSE_ALARMS
from slip.delay import DelayAtRate

LEVEL = 0.95
DRAWS = 400
BOOTSTRAP = "bootstrap over trials"
POISSON = "Poisson, no alarm seen"


def share(name: str, hits: list[bool], direction: Any = "higher") -> Metric:
    """Share of trials, with Wilson's interval."""
    low, high = wilson(sum(hits), len(hits), LEVEL)
    n = len(hits)
    return Metric(
        name=name, value=sum(hits) / n, direction=direction, n=n, groups=n, low=low, high=high, interval=WILSON
    )


def rate_per_minute(name: str, counts: NDArray[np.float64], minutes: NDArray[np.float64]) -> Iterator[Metric]:
    """Alarms a minute, from counts and minutes of each trial; none without time."""
    time = float(minutes.sum())
    if not time > 0.0:
        return
    value, how = float(counts.sum()) / time, BOOTSTRAP
    if counts.sum() == 0:
        low, high, how = 0.0, float(-np.log((1 - LEVEL) / 2)) / time, POISSON
    else:
        drawn = np.random.default_rng(0).integers(0, len(counts), (DRAWS, len(counts)))
        rates = counts[drawn].sum(1) / np.maximum(minutes[drawn].sum(1), 1e-9)
        low, high = (float(end) for end in np.quantile(rates, [(1 - LEVEL) / 2, (1 + LEVEL) / 2]))
    yield Metric(
        name=name,
        value=value,
        unit="false alarms a minute",
        direction="lower",
        n=len(counts),
        groups=len(counts),
        low=min(low, value),
        high=max(high, value),
        interval=how,
    )


def median_delay(name: str, delays: NDArray[np.float64]) -> Metric:
    """Median delay in seconds -> ms, a miss infinite; of an even count the later one."""
    rng = np.random.default_rng(0)
    n = len(delays)
    drawn = np.sort(rng.choice(delays, (DRAWS, n)), axis=1)[:, n // 2]
    low, high = np.quantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], method="nearest")
    median = float(np.sort(delays)[n // 2])
    return delay_metric(name, median, (float(low), float(high)), {"n": n, "groups": n, "interval": BOOTSTRAP})


def delay_metric(name: str, seconds: float, interval_s: tuple[float, float], shared: dict[str, Any]) -> Metric:
    """A delay in milliseconds; what is infinite stands as `MISSED_MS`."""
    value, low, high = (float(np.clip(1e3 * s, -MISSED_MS, MISSED_MS)) for s in (seconds, *interval_s))
    return Metric(
        name=name, value=value, unit="ms", direction="lower", low=min(low, value), high=max(high, value), **shared
    )


def difference(ours: DelayAtRate, theirs: DelayAtRate) -> float:
    """Median delay less the baseline's, in seconds; 0 where both miss most slips."""
    if np.isinf(ours.median_s) and np.isinf(theirs.median_s):
        return 0.0
    return ours.median_s - theirs.median_s


def expected_alarms(at: str, rate: float, measured: DelayAtRate, trials: int) -> Metric:
    """False alarms that a rate leads to expect in the trials' quiet time: what supports it."""
    unit = f"alarms, {EXPECTED_FALSE_ALARMS} support a rate"
    return Metric(name=f"expected_alarms{at}", value=rate * measured.quiet_minutes, unit=unit, n=trials, groups=trials)
