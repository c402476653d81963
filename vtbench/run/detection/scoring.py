"""Traces and truth of a slip task -> metrics with intervals over trials. Never runs a detector.

A metric is named `what@rate[factor=value]`: `@1` at one false alarm a minute, with the threshold that gives that rate
on these trials; without `@` at the threshold of the training trials. What a delay of a miss is: `leaderboard.slips`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import Metric
from leaderboard.slips import MISSED_MS
from leaderboard.statistics import WILSON, wilson
from slip.alarms import EXPECTED_FALSE_ALARMS, Trial, quiet_peaks
from slip.delay import DelayAtRate, delay_at_rate, onset_delay, paired_delay_interval
from slip.roc import roc_by_trial
from vtbench.run.detection.traces import Traces, kept_rule, trial_of
from vtbench.tasks.slides import RECOVERED, SlideData, SlideTruth, SlipTask

DRAWS = 400
LEVEL = 0.95
BOOTSTRAP = "bootstrap over trials"
POISSON = "Poisson, no alarm seen"
FACTORS = ("object", "kind", "speed", "load", "direction")

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Scored:
    """Trials of one detector with what happened in them; scores divided by the threshold, so that 1 is an alarm."""

    trials: list[Trial]
    truth: list[SlideTruth]
    task: SlipTask


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
        *at_rates(own, beside),
        *area(own),
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
    return Scored(trials, truth, task)


def at_threshold(scored: Scored) -> Iterator[Metric]:
    """Slips found, delay, false alarms, trials without slip called slip, at the threshold of the training trials."""
    yield from _found(scored, 1.0, "")
    rule = kept_rule(scored.task.rule)
    quiet = [quiet_peaks(trial, rule) for trial in scored.trials]
    slips = [at for at, what in enumerate(scored.truth) if what.onset is not None]
    called = [bool((quiet[at][0] >= 1.0).any()) for at in slips if quiet[at][1] > 0.0]
    if called:
        yield _share("false_alarm_trials", called, "lower")
    yield from _false_alarms(scored, quiet, 1.0, "")
    for kind in _kinds_without_slip(scored):
        mine = [at for at, what in enumerate(scored.truth) if what.kind == kind and what.onset is None]
        yield _share(f"called[kind={kind}]", [bool((scored.trials[at].score >= 1.0).any()) for at in mine], "lower")


def at_rates(own: Scored, beside: Scored) -> Iterator[Metric]:
    """Delay, slips found and the pairing with the energy baseline, at each rate of false alarms."""
    rule, counted = kept_rule(own.task.rule), _counted(own)
    trials, others = _pick(own.trials, counted), _pick(beside.trials, counted)
    for rate in own.task.rates:
        ours = delay_at_rate(trials, rate, rule, level=LEVEL, draws=DRAWS)
        theirs = delay_at_rate(others, rate, rule, level=LEVEL, draws=DRAWS)
        slips = len(ours.delays_s)
        low, high = ours.detected_interval
        at = f"@{rate:g}"
        yield Metric(
            name=f"expected_alarms{at}",
            value=rate * ours.quiet_minutes,
            unit=f"alarms, {EXPECTED_FALSE_ALARMS} support a rate",
            n=len(trials),
            groups=len(trials),
        )
        shared = {"n": slips, "groups": slips, "interval": BOOTSTRAP}
        yield Metric(name=f"detected{at}", value=ours.detected, low=low, high=high, **shared)
        yield _delay(f"delay_ms{at}", ours.median_s, ours.median_interval_s, shared)
        yield _delay(f"energy_delay_ms{at}", theirs.median_s, theirs.median_interval_s, shared)
        yield _delay(
            f"delay_minus_energy_ms{at}", _difference(ours, theirs), paired_delay_interval(ours, theirs, LEVEL), shared
        )
        shifted = replace(own, trials=trials, truth=_pick(own.truth, counted))
        yield from _by_factor(shifted, ours.beta, at)
        yield from _false_alarms(shifted, [quiet_peaks(trial, rule) for trial in trials], ours.beta, at)
        recovered = [t for t, what in zip(own.trials, own.truth, strict=True) if what.kind == RECOVERED]
        if recovered:
            called = [bool((trial.score >= ours.beta).any()) for trial in recovered]
            yield _share(f"called{at}[kind={RECOVERED}]", called, "lower")


def area(scored: Scored) -> Iterator[Metric]:
    """Area of the ROC by trial, where there are trials with and without slip that are alike in length."""
    trials = [t for t, what in zip(scored.trials, scored.truth, strict=True) if what.comparable]
    with_slip = sum(trial.onset is not None for trial in trials)
    if 0 < with_slip < len(trials):
        roc = roc_by_trial(trials, kept_rule(scored.task.rule), level=LEVEL)
        low, high = (min(roc.area_interval[0], roc.area), max(roc.area_interval[1], roc.area))
        n = len(trials)
        yield Metric(
            name="roc_area", value=roc.area, unit="area", n=n, groups=n, low=low, high=high, interval=BOOTSTRAP
        )


def _found(scored: Scored, beta: float, at: str) -> Iterator[Metric]:
    """Share of the slips found and median delay, of all and by each factor."""
    rule = kept_rule(scored.task.rule)
    slips = [(t, what) for t, what in zip(scored.trials, scored.truth, strict=True) if what.onset is not None]
    delays = np.array([onset_delay(trial, beta, rule) for trial, _ in slips])
    if len(slips):
        yield _share(f"detected{at}", np.isfinite(delays).tolist())
        yield _median(f"delay_ms{at}", delays)
    yield from _by_factor(scored, beta, at)


def _by_factor(scored: Scored, beta: float, at: str) -> Iterator[Metric]:
    rule = kept_rule(scored.task.rule)
    slips = [(t, what) for t, what in zip(scored.trials, scored.truth, strict=True) if what.onset is not None]
    delays = np.array([onset_delay(trial, beta, rule) for trial, _ in slips])
    for factor in FACTORS:
        values = [getattr(what, factor) for _, what in slips]
        levels = list(dict.fromkeys(values))
        if len(levels) < 2:
            continue
        for level in levels:
            mine = delays[[value == level for value in values]]
            yield _share(f"detected{at}[{factor}={level}]", np.isfinite(mine).tolist())
            yield _median(f"delay_ms{at}[{factor}={level}]", mine)


def _false_alarms(
    scored: Scored, quiet: list[tuple[NDArray[np.float64], float]], beta: float, at: str
) -> Iterator[Metric]:
    """False alarms a minute over all quiet time and by kind of trial; recovered incipient slip does not count."""
    counts = np.array([float((peaks >= beta).sum()) for peaks, _ in quiet])
    minutes = np.array([spent for _, spent in quiet])
    kinds = np.array([what.kind for what in scored.truth])
    counted = kinds != RECOVERED
    yield from _rate(f"false_alarms_per_min{at}", counts[counted], minutes[counted])
    for kind in dict.fromkeys(kinds[counted].tolist()):
        yield from _rate(f"false_alarms_per_min{at}[kind={kind}]", counts[kinds == kind], minutes[kinds == kind])


def _rate(name: str, counts: NDArray[np.float64], minutes: NDArray[np.float64]) -> Iterator[Metric]:
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


def _share(name: str, hits: list[bool], direction: Any = "higher") -> Metric:
    low, high = wilson(sum(hits), len(hits), LEVEL)
    n = len(hits)
    return Metric(
        name=name, value=sum(hits) / n, direction=direction, n=n, groups=n, low=low, high=high, interval=WILSON
    )


def _median(name: str, delays: NDArray[np.float64]) -> Metric:
    """Median delay at a fixed threshold; of an even count the later one."""
    rng = np.random.default_rng(0)
    drawn = np.sort(rng.choice(delays, (DRAWS, len(delays))), axis=1)[:, len(delays) // 2]
    low, high = np.quantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], method="nearest")
    n = len(delays)
    median = float(np.sort(delays)[n // 2])
    return _delay(name, median, (float(low), float(high)), {"n": n, "groups": n, "interval": BOOTSTRAP})


def _delay(name: str, seconds: float, interval_s: tuple[float, float], shared: dict[str, Any]) -> Metric:
    value, low, high = (float(np.clip(1e3 * s, -MISSED_MS, MISSED_MS)) for s in (seconds, *interval_s))
    return Metric(
        name=name, value=value, unit="ms", direction="lower", low=min(low, value), high=max(high, value), **shared
    )


def _difference(ours: DelayAtRate, theirs: DelayAtRate) -> float:
    """Median delay less the baseline's, in seconds; 0 where both miss most slips."""
    if np.isinf(ours.median_s) and np.isinf(theirs.median_s):
        return 0.0
    return ours.median_s - theirs.median_s


def _counted(scored: Scored) -> list[int]:
    """Trials that count for rates of false alarms: all but those that slip in part and recover."""
    return [at for at, what in enumerate(scored.truth) if what.kind != RECOVERED]


def _kinds_without_slip(scored: Scored) -> list[str]:
    return list(dict.fromkeys(what.kind for what in scored.truth if what.onset is None))


def _pick(values: list[Any], places: list[int]) -> list[Any]:
    return [values[at] for at in places]
