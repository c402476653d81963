"""One cell of a slip task: thresholds from the training trials, scores of the test trials, fold by fold."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slip.delay import onset_delay
from vtbench.run.detection.cost import cost_us
from vtbench.run.detection.looking import frames_of, looks, trial_scores
from vtbench.run.detection.methods import BASELINE
from vtbench.run.detection.thresholds import Fitted, fit, seen
from vtbench.run.detection.traces import Trace, Traces, kept_rule, trace_of, trial_of
from vtbench.run.evaluate import Outcome
from vtbench.tasks.base import Fold, Split
from vtbench.tasks.slides import SlideData, SlipTask


@dataclass(frozen=True)
class DetectionWork:
    """All that a worker needs for one cell of a slip task; forces are read from their datasets."""

    key: str
    detector: str
    feed: str
    split: Split
    samples: str
    data: SlideData
    task: SlipTask
    timeout_s: float

    def evaluate(self) -> Outcome:
        """Run the cell; see `detect`."""
        return detect(self)


@dataclass(frozen=True)
class Run:
    """A detector on a whole split: its threshold in each fold, and the trace of each test trial in fold order.

    `rest` holds, of each test trial, the samples at rest that score beta or more, and all settled ones at rest.
    """

    fitted: list[Fitted]
    traces: list[Trace]
    seconds: float
    samples: int
    rest: list[tuple[int, int]] = field(default_factory=list)


_baselines: dict[tuple[str, str, str], Run] = {}


def detect(work: DetectionWork) -> Outcome:
    """Run one cell, and the energy baseline on the same terms beside it.

    Returns:
        an outcome with the arrays `sample_id`, `group`, `fold`, `label` (1 where an alarm is raised in a slip, or in a
        trial without one), `held` and `held_length` (see `traces`), `beta` a fold, the same of the baseline, `cost_us`
        (batch, stream), `rest` (alarms before hold-on and samples of each trial's rest) and `choices` (JSON a fold).
    """
    start = time.perf_counter()
    own = run_detector(work.detector, work)
    fitted_s = time.perf_counter() - start - own.seconds
    name = (work.samples, work.split.name, work.feed)
    if work.detector == BASELINE:
        _baselines[name] = own
    elif name not in _baselines:
        _baselines[name] = run_detector(BASELINE, work)
    beside = _baselines[name]
    trial, force = next(work.data.each_force(work.split.folds[0].test[:1]))
    detector = own.fitted[0].detector
    costs = cost_us(detector, seen(force, work.feed), frames_of(work.data, trial) if looks(detector) else None)
    predictions = packed(work, own, beside, costs)
    return Outcome(work.key, "ok", predictions=predictions, fit_s=fitted_s / len(work.split.folds), predict_us=costs[0])


def packed(work: DetectionWork, own: Run, beside: Run, costs_us: tuple[float, float]) -> dict[str, NDArray[Any]]:
    """The arrays that `detect` promises; `costs_us` is (batch, stream)."""
    tested = np.concatenate([fold.test for fold in work.split.folds])
    fold_of = np.concatenate([np.full(len(fold.test), at, np.int32) for at, fold in enumerate(work.split.folds)])
    betas = np.array([each.beta / each.unit for each in own.fitted])
    kept, kept_beside = Traces.of(own.traces), Traces.of(beside.traces)
    return {
        "sample_id": work.data.ids[tested],
        "group": work.split.interval_groups[tested],
        "fold": fold_of,
        "label": _called(work, tested, own.traces, betas[fold_of]),
        "held": kept.values,
        "held_length": kept.lengths,
        "beta": betas,
        "baseline_held": kept_beside.values,
        "baseline_held_length": kept_beside.lengths,
        "cost_us": np.array(costs_us),
        "rest": np.array(own.rest, np.int64).reshape(-1, 2),
        "choices": np.array([json.dumps(each.note, sort_keys=True) for each in own.fitted]),
    }


def run_detector(name: str, work: DetectionWork) -> Run:
    """A detector on every fold."""
    fitted, traces, rest, seconds, samples = [], [], [], 0.0, 0
    for fold in work.split.folds:
        found = fit(name, work.feed, work.data, fold.train, work.task.cfar_rate, work.task.window)
        start = time.perf_counter()
        for trace, at_rest in _tested(found, work, fold):
            traces.append(trace)
            rest.append(at_rest)
        seconds += time.perf_counter() - start
        samples += sum(work.data.truth[trial].samples for trial in fold.test.tolist())
        fitted.append(found)
    return Run(fitted, traces, seconds, samples, rest)


def test_traces(found: Fitted, work: DetectionWork, fold: Fold) -> list[Trace]:
    """Traces of a fold's test trials, in their order."""
    return [trace for trace, _ in _tested(found, work, fold)]


def _tested(found: Fitted, work: DetectionWork, fold: Fold) -> list[tuple[Trace, tuple[int, int]]]:
    """Trace of each test trial in the fold's order, with its alarms and settled samples at rest."""
    by_trial = {}
    for trial, force in work.data.each_force(fold.test):
        truth = work.data.truth[trial]
        scores = trial_scores(found.detector, work.data, trial, seen(force, work.feed))
        at_rest = scores[min(found.detector.settling, truth.rest) : truth.rest]
        alarms = int((at_rest >= found.beta).sum())
        by_trial[trial] = trace_of(scores / found.unit, truth, work.task.rule), (alarms, len(at_rest))
    return [by_trial[trial] for trial in fold.test.tolist()]


def _called(
    work: DetectionWork, tested: NDArray[np.int64], traces: list[Trace], betas: NDArray[np.float64]
) -> NDArray[np.int32]:
    rule, called = kept_rule(work.task.rule), []
    for trial, trace, beta in zip(tested.tolist(), traces, betas, strict=True):
        truth = work.data.truth[trial]
        made = trial_of(trace.astype(np.float64), truth, work.task.rule)
        slipped = truth.onset is not None
        called.append(np.isfinite(onset_delay(made, beta, rule)) if slipped else bool((made.score >= beta).any()))
    return np.array(called, np.int32)
