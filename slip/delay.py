"""Delay from the true onset, at a fixed number of false alarms a minute, with a bootstrap over trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slip.alarms import AlarmRule, Trial, held_score, quiet_peaks, threshold_at_rate
from slip.samples import Floats


@dataclass(frozen=True)
class DelayAtRate:
    """Onset delays of one detector at a fixed false-alarm rate.

    beta : the threshold; supported : whether the quiet time suffices for the rate (30 expected false alarms);
    delays_s : one per slip trial, inf where missed; median_s and detected (a share) with intervals (low, high).
    draws_median_s : medians of the bootstrap draws, for paired comparisons by `paired_delay_interval`.
    """

    per_minute: float
    beta: float
    supported: bool
    quiet_minutes: float
    delays_s: Floats
    median_s: float
    median_interval_s: tuple[float, float]
    detected: float
    detected_interval: tuple[float, float]
    draws_median_s: Floats


def onset_delay(trial: Trial, beta: float, rule: AlarmRule) -> float:
    """Seconds from onset to the alarm at `beta`; inf where the slip is missed. Raises ValueError without slip.

    The alarm must be raised within the slip or up to `early_s` before it (a negative delay): one that has been
    on since before is a false alarm, not a detection.
    """
    if trial.onset is None or trial.end is None:
        raise ValueError("expected a slip trial, got one without an onset")
    return _delay(held_score(trial, rule), trial.onset, trial.end, trial.rate_hz, beta, rule)


def delay_at_rate(
    trials: Sequence[Trial],
    per_minute: float,
    rule: AlarmRule | None = None,
    *,
    level: float = 0.95,
    draws: int = 1000,
    seed: int = 0,
) -> DelayAtRate:
    """Measure onset delays at the least beta that gives at most `per_minute` false alarms.

    The bootstrap redraws whole trials, those with and those without slip apart, and sets beta anew in each draw, so
    the threshold's error is in the interval. With the same trials in the same order and the same seed the draws of
    two detectors are paired. Raises ValueError without slip trials or without quiet time.
    """
    rule = rule or AlarmRule()
    slips = [trial for trial in trials if trial.onset is not None]
    if not slips:
        raise ValueError("expected at least one slip trial, got none")
    quiet = [quiet_peaks(trial, rule) for trial in trials]
    beta, supported = _threshold(quiet, np.arange(len(trials)), per_minute)
    delays = np.array([onset_delay(trial, beta, rule) for trial in slips])
    has_slip = np.array([trial.onset is not None for trial in trials])
    held = [held_score(trial, rule) if trial.onset is not None else np.zeros(0) for trial in trials]
    rng = np.random.default_rng(seed)
    medians, shares = np.empty(draws), np.empty(draws)
    for draw in range(draws):
        drawn = _redraw(has_slip, rng)
        drawn_beta, _ = _threshold(quiet, drawn, per_minute)
        drawn_delays = np.array(
            [
                _delay(held[i], trial.onset, trial.end, trial.rate_hz, drawn_beta, rule)
                for i in drawn
                if (trial := trials[i]).onset is not None and trial.end is not None
            ]
        )
        medians[draw], shares[draw] = _median(drawn_delays), np.isfinite(drawn_delays).mean()
    return DelayAtRate(
        per_minute=per_minute,
        beta=beta,
        supported=supported,
        quiet_minutes=sum(minutes for _, minutes in quiet),
        delays_s=delays,
        median_s=_median(delays),
        median_interval_s=_interval(medians, level),
        detected=float(np.isfinite(delays).mean()),
        detected_interval=_interval(shares, level),
        draws_median_s=medians,
    )


def paired_delay_interval(first: DelayAtRate, second: DelayAtRate, level: float = 0.95) -> tuple[float, float]:
    """Interval in seconds of the first detector's median delay less the second's, over the same trials and seed.

    A draw in which both miss most slips counts as no difference; one alone as infinitely worse.
    """
    if len(first.draws_median_s) != len(second.draws_median_s) or len(first.delays_s) != len(second.delays_s):
        raise ValueError("expected two results over the same trials and draws: they cannot be paired")
    a, b = first.draws_median_s, second.draws_median_s
    one_detects = np.isfinite(a) | np.isfinite(b)
    return _interval(np.subtract(a, b, out=np.zeros_like(a), where=one_detects), level)


def _delay(held: Floats, onset: int, end: int, rate_hz: float, beta: float, rule: AlarmRule) -> float:
    earliest = max(onset - round(rule.early_s * rate_hz), 0)
    on = held[max(earliest - 1, 0) : end] >= beta
    already = on[0] if earliest > 0 else False
    raised = np.flatnonzero(on & ~np.concatenate([[already], on[:-1]]))
    if len(raised) == 0:
        return float("inf")
    return float(raised[0] + max(earliest - 1, 0) - onset) / rate_hz


def _threshold(quiet: list[tuple[Floats, float]], chosen: NDArray[np.intp], per_minute: float) -> tuple[float, bool]:
    peaks = [quiet[index][0] for index in chosen]
    return threshold_at_rate(peaks, sum(quiet[index][1] for index in chosen), per_minute)


def _redraw(has_slip: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.intp]:
    strata = [np.flatnonzero(has_slip), np.flatnonzero(~has_slip)]
    return np.concatenate([rng.choice(s, size=len(s)) for s in strata if len(s)])


def _median(delays: Floats) -> float:
    return float(np.sort(delays)[len(delays) // 2])  # of an even count the later one: a miss is never averaged


def _interval(values: Floats, level: float) -> tuple[float, float]:
    low, high = np.quantile(values, [(1.0 - level) / 2.0, (1.0 + level) / 2.0], method="nearest")
    return float(low), float(high)
