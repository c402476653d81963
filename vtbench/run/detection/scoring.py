"""Traces and truth of a slip task -> metrics with intervals over trials. Never runs a detector.

A metric is named `what@rate[factor=value]`: `@1` at one false alarm a minute, with the threshold that gives that rate
on these trials; without `@` at the threshold of the training trials. What a delay of a miss is: `leaderboard.slips`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import Metric
from slip.alarms import AlarmRule, Trial, quiet_peaks
from slip.delay import delay_at_rate, onset_delay, paired_delay_interval
from vtbench.run.detection.at_rest import rest_rates
from vtbench.run.detection.metrics import (
    BOOTSTRAP,
    DRAWS,
    LEVEL,
    delay_metric,
    difference,
    expected_alarms,
    median_delay,
    rate_per_minute,
    share,
)
from vtbench.run.detection.negatives import against_each_kind, area_metric
from vtbench.run.detection.traces import Traces, kept_rule, trial_of
from vtbench.tasks.slides import RECOVERED, SlideData, SlideTruth, SlipTask

FACTORS = ("object", "kind", "speed", "load", "direction")

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Scored:
    """Trials of one detector with what happened in them, and the rule for their held scores."""

    trials: list[Trial]
    truth: list[SlideTruth]
    rule: AlarmRule

    def take(self, places: list[int]) -> Scored:
        """Some of the trials."""
        return Scored([self.trials[at] for at in places], [self.truth[at] for at in places], self.rule)


def score_slips(predictions: Arrays, data: SlideData, task: SlipTask) -> tuple[Metric, ...]:
    """Metrics of one cell, the share of the slips that were found first.

    Raises:
        ValueError: a prediction for a trial that the data do not hold.
    """
    known = {name: at for at, name in enumerate(data.ids.tolist())}
    names = predictions["sample_id"].tolist()
    if lost := [name for name in names if name not in known]:
        raise ValueError(f"prediction for trial {lost[0]!r}, which the data do not hold")
    truth = [data.truth[known[name]] for name in names]
    ones = np.ones(len(names))
    own = _scored(predictions, "held", truth, task, ones)
    beside = _scored(predictions, "baseline_held", truth, task, ones)
    fitted = _scored(predictions, "held", truth, task, predictions["beta"][predictions["fold"]])
    batch_us, stream_us = predictions["cost_us"].tolist()
    return (
        *at_threshold(fitted),
        *at_rates(own, beside, task.rates),
        *against_each_kind(own.trials, beside.trials, truth, max(task.rates), own.rule),
        *area(own),
        *rest_rates(predictions),
        Metric(name="batch_us", value=batch_us, unit="µs a sample", direction="lower", n=1, groups=1),
        Metric(name="stream_us", value=stream_us, unit="µs a sample", direction="lower", n=1, groups=1),
    )


def _scored(
    predictions: Arrays, name: str, truth: list[SlideTruth], task: SlipTask, unit: NDArray[np.float64]
) -> Scored:
    kept = Traces(predictions[name], predictions[f"{name}_length"]).split()
    trials = [
        trial_of(trace.astype(np.float64) / by, what, task.rule)
        for trace, what, by in zip(kept, truth, unit, strict=True)
    ]
    return Scored(trials, truth, kept_rule(task.rule))


def at_threshold(scored: Scored) -> Iterator[Metric]:
    """Slips found, delay, false alarms, trials without slip called slip, where a score of 1 is the fitted threshold."""
    slips = [at for at, what in enumerate(scored.truth) if what.onset is not None]
    if slips:
        delays = _delays(scored, 1.0)
        yield share("detected", np.isfinite(delays).tolist())
        yield median_delay("delay_ms", delays)
    yield from _by_factor(scored, 1.0, "")
    quiet = [quiet_peaks(scored.trials[at], scored.rule) for at in slips]
    called = [bool((peaks >= 1.0).any()) for peaks, minutes in quiet if minutes > 0.0]
    if called:
        yield share("false_alarm_trials", called, "lower")
    yield from _false_alarms(scored, 1.0, "")
    for kind in dict.fromkeys(what.kind for what in scored.truth if what.onset is None):
        mine = [at for at, what in enumerate(scored.truth) if what.kind == kind and what.onset is None]
        yield share(f"called[kind={kind}]", _called(scored.take(mine), 1.0), "lower")


def at_rates(own: Scored, beside: Scored, rates: tuple[float, ...]) -> Iterator[Metric]:
    """Delay, slips found and the pairing with the energy baseline, at each rate of false alarms."""
    counted = [at for at, what in enumerate(own.truth) if what.kind != RECOVERED]
    recovered = [at for at, what in enumerate(own.truth) if what.kind == RECOVERED]
    mine, theirs = own.take(counted), beside.take(counted)
    for rate in rates:
        ours = delay_at_rate(mine.trials, rate, own.rule, level=LEVEL, draws=DRAWS)
        energy = delay_at_rate(theirs.trials, rate, own.rule, level=LEVEL, draws=DRAWS)
        n, at = len(ours.delays_s), f"@{rate:g}"
        shared: dict[str, Any] = {"n": n, "groups": n, "interval": BOOTSTRAP}
        low, high = ours.detected_interval
        yield expected_alarms(at, rate, ours, len(counted))
        yield Metric(name=f"detected{at}", value=ours.detected, low=low, high=high, **shared)
        yield delay_metric(f"delay_ms{at}", ours.median_s, ours.median_interval_s, shared)
        yield delay_metric(f"energy_delay_ms{at}", energy.median_s, energy.median_interval_s, shared)
        paired = paired_delay_interval(ours, energy, LEVEL)
        yield delay_metric(f"delay_minus_energy_ms{at}", difference(ours, energy), paired, shared)
        yield from _by_factor(mine, ours.beta, at)
        yield from _false_alarms(mine, ours.beta, at)
        if recovered:
            yield share(f"called{at}[kind={RECOVERED}]", _called(own.take(recovered), ours.beta), "lower")


def area(scored: Scored) -> Iterator[Metric]:
    """Area of the ROC by trial, where there are trials with and without slip that are alike in length."""
    trials = [t for t, what in zip(scored.trials, scored.truth, strict=True) if what.comparable]
    if 0 < sum(trial.onset is not None for trial in trials) < len(trials):
        yield area_metric("roc_area", trials, scored.rule)


def _delays(scored: Scored, beta: float) -> NDArray[np.float64]:
    """Delay of each slip in seconds, infinite where it is missed."""
    slips = [t for t, what in zip(scored.trials, scored.truth, strict=True) if what.onset is not None]
    return np.array([onset_delay(trial, beta, scored.rule) for trial in slips])


def _called(scored: Scored, beta: float) -> list[bool]:
    return [bool((trial.score >= beta).any()) for trial in scored.trials]


def _by_factor(scored: Scored, beta: float, at: str) -> Iterator[Metric]:
    """Slips found and median delay by each condition that varies."""
    delays = _delays(scored, beta)
    for factor in FACTORS:
        values = [getattr(what, factor) for what in scored.truth if what.onset is not None]
        levels = list(dict.fromkeys(values))
        for level in levels if len(levels) > 1 else ():
            mine = delays[[value == level for value in values]]
            yield share(f"detected{at}[{factor}={level}]", np.isfinite(mine).tolist())
            yield median_delay(f"delay_ms{at}[{factor}={level}]", mine)


def _false_alarms(scored: Scored, beta: float, at: str) -> Iterator[Metric]:
    """False alarms a minute over all quiet time and by kind of trial; recovered incipient slip does not count."""
    quiet = [quiet_peaks(trial, scored.rule) for trial in scored.trials]
    counts = np.array([float((peaks >= beta).sum()) for peaks, _ in quiet])
    minutes = np.array([spent for _, spent in quiet])
    kinds = np.array([what.kind for what in scored.truth])
    counted = kinds != RECOVERED
    yield from rate_per_minute(f"false_alarms_per_min{at}", counts[counted], minutes[counted])
    for kind in dict.fromkeys(kinds[counted].tolist()):
        name = f"false_alarms_per_min{at}[kind={kind}]"
        yield from rate_per_minute(name, counts[kinds == kind], minutes[kinds == kind])
