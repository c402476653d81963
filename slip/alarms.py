"""Trials with true onsets, the alarm rule, and the threshold at a fixed number of false alarms a minute."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slip.hold import check_periods
from slip.samples import Floats
from slip.windows import window_min

EXPECTED_FALSE_ALARMS = 30  # a rate is measured where at least so many are expected: 300 min for 0.1 a minute


@dataclass(frozen=True)
class Trial:
    """The scores of one trial and what truly happened in it.

    score : (T,) finite; rate_hz : samples per second; onset, end : first slipping sample and the one after the last,
    both None without slip; kind : what the trial is ("slip", "tapping", ...); group : the object or the condition.
    """

    score: Floats
    rate_hz: float
    onset: int | None = None
    end: int | None = None
    kind: str = "slip"
    group: str = ""

    def __post_init__(self) -> None:
        score = np.asarray(self.score, dtype=np.float64)
        if score.ndim != 1 or not np.isfinite(score).all():
            raise ValueError(f"expected finite scores of shape (T,), got {score.shape} with or without NaN")
        if not self.rate_hz > 0.0:
            raise ValueError(f"expected a positive rate_hz, got {self.rate_hz!r}")
        if (self.onset is None) != (self.end is None):
            raise ValueError(f"expected both onset and end of the slip or neither, got {self.onset} and {self.end}")
        if self.onset is not None and self.end is not None and not 0 <= self.onset < self.end <= len(score):
            raise ValueError(f"expected a slip within the trial's {len(score)} samples, got {self.onset} to {self.end}")
        object.__setattr__(self, "score", score)


@dataclass(frozen=True)
class AlarmRule:
    """When a score is an alarm and how alarms are counted.

    periods : consecutive samples at or above beta that raise an alarm.
    refractory_s : time without slip is cut into pieces this long; a piece with any alarm counts once, so that one
        long alarm is not many and the count never rises with beta.
    early_s : an alarm raised this long before the onset still detects it.
    settle_s : time after the slip's end that counts neither way.
    """

    periods: int = 3
    refractory_s: float = 1.0
    early_s: float = 0.0
    settle_s: float = 0.5

    def __post_init__(self) -> None:
        check_periods(self.periods)
        if not (self.refractory_s > 0.0 and self.early_s >= 0.0 and self.settle_s >= 0.0):
            raise ValueError("expected refractory_s above 0 s and early_s, settle_s of at least 0 s")


def held_score(trial: Trial, rule: AlarmRule) -> Floats:
    """Largest beta at which each sample is in alarm: the smallest of its last `periods` scores; (T,)."""
    lead = np.full(rule.periods - 1, -np.inf)
    return window_min(np.concatenate([lead, trial.score]), rule.periods)


def quiet_peaks(trial: Trial, rule: AlarmRule) -> tuple[Floats, float]:
    """Return the largest held score of each piece of the trial without slip, and those pieces' time in minutes."""
    held = held_score(trial, rule)
    length = max(round(rule.refractory_s * trial.rate_hz), 1)
    if trial.onset is None or trial.end is None:
        parts = [held]
    else:
        before = max(trial.onset - round(rule.early_s * trial.rate_hz), 0)
        parts = [held[:before], held[trial.end + round(rule.settle_s * trial.rate_hz) :]]
    peaks = [np.maximum.reduceat(part, np.arange(0, len(part), length)) for part in parts if len(part)]
    minutes = sum(len(part) for part in parts) / trial.rate_hz / 60.0
    return np.concatenate([np.zeros(0), *peaks]), minutes


def threshold_at_rate(peaks: Sequence[Floats], minutes: float, per_minute: float) -> tuple[float, bool]:
    """Return the least beta with at most `per_minute` false alarms, and whether the time suffices to say so.

    peaks : of each trial, from `quiet_peaks`; minutes : their time in all. Below 30 expected alarms the flag is
    False: the threshold is an extrapolation from too little. Raises ValueError without any time.
    """
    if not per_minute > 0.0:
        raise ValueError(f"expected a positive number of false alarms a minute, got {per_minute!r}")
    every = np.concatenate([np.zeros(0), *peaks])
    if len(every) == 0 or not minutes > 0.0:
        raise ValueError("expected time without slip to count false alarms in, got none")
    allowed = int(per_minute * minutes)
    supported = per_minute * minutes >= EXPECTED_FALSE_ALARMS
    if allowed >= len(every):
        return -np.inf, supported
    highest_refused = np.partition(every, len(every) - 1 - allowed)[len(every) - 1 - allowed]
    return float(np.nextafter(highest_refused, np.inf)), supported


def false_alarms_per_minute(trials: Sequence[Trial], beta: float, rule: AlarmRule) -> dict[str, float]:
    """Return the rate of false alarms by kind of trial at `beta`; NaN for a kind without quiet time."""
    count: dict[str, int] = {}
    time: dict[str, float] = {}
    for trial in trials:
        peaks, minutes = quiet_peaks(trial, rule)
        count[trial.kind] = count.get(trial.kind, 0) + int((peaks >= beta).sum())
        time[trial.kind] = time.get(trial.kind, 0.0) + minutes
    return {kind: count[kind] / time[kind] if time[kind] > 0.0 else float("nan") for kind in count}
