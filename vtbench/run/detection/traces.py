"""Scores of trials in the form that is kept: what alarms can ever depend on, and no more.

A score is an alarm after `periods` samples in a row, so the smallest of the last `periods` scores is kept. Of a trial
without slip only the largest value of each piece counts that false alarms are counted in. Of a trial with slip all of
it is kept, without the partial slip that began longer than `early_s` before the onset: it is neither quiet nor slip.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slip.alarms import AlarmRule, Trial, held_score, quiet_peaks
from vtbench.tasks.slides import SlideTruth

Trace = NDArray[np.float32]


def kept_rule(rule: AlarmRule) -> AlarmRule:
    """The rule for traces, whose values are held already."""
    return replace(rule, periods=1)


def trace_of(score: NDArray[np.float64], truth: SlideTruth, rule: AlarmRule) -> Trace:
    """What is kept of the scores (T,) of one trial."""
    trial = Trial(score, truth.rate_hz)
    if truth.onset is None:
        return _finite(_whole_pieces(quiet_peaks(trial, rule)[0], truth, rule))
    return np.delete(_finite(held_score(trial, rule)), _left_out(truth, rule))


def trial_of(trace: NDArray[np.float64], truth: SlideTruth, rule: AlarmRule) -> Trial:
    """The trial that a trace stands for, to be scored by `kept_rule`."""
    if truth.onset is None or truth.end is None:
        rate = len(trace) * truth.rate_hz / truth.samples
        return Trial(trace, rate, kind=truth.kind, group=truth.object)
    cut = len(_left_out(truth, rule))
    return Trial(trace, truth.rate_hz, truth.onset - cut, truth.end - cut, kind=truth.kind, group=truth.object)


def _left_out(truth: SlideTruth, rule: AlarmRule) -> NDArray[np.int64]:
    """Samples of partial slip too long before the onset to count as early."""
    assert truth.onset is not None
    early = max(truth.onset - round(rule.early_s * truth.rate_hz), 0)
    return np.arange(early if truth.partial is None else min(truth.partial, early), early)


def _whole_pieces(peaks: NDArray[np.float64], truth: SlideTruth, rule: AlarmRule) -> NDArray[np.float64]:
    """Peaks of pieces; a last piece shorter than half counts with the one before it."""
    length = max(round(rule.refractory_s * truth.rate_hz), 1)
    if len(peaks) > 1 and 0 < truth.samples % length < length / 2:
        return np.append(peaks[:-2], peaks[-2:].max())
    return peaks


def _finite(held: NDArray[np.float64]) -> Trace:
    """Before enough samples came there is no alarm at any threshold: the smallest value stands for that."""
    known = np.isfinite(held)
    floor = held[known].min() if known.any() else 0.0
    return np.where(known, held, floor).astype(np.float32)


@dataclass(frozen=True)
class Traces:
    """Traces of many trials below each other, as they are kept in a prediction file.

    Attributes:
        values: (sum,) of all traces.
        lengths: (n,) of each.
    """

    values: Trace
    lengths: NDArray[np.int64]

    @classmethod
    def of(cls, traces: list[Trace]) -> Traces:
        """Put traces below each other."""
        return cls(
            np.concatenate([np.empty(0, np.float32), *traces]), np.array([len(trace) for trace in traces], np.int64)
        )

    def split(self) -> list[Trace]:
        """The traces, one a trial."""
        return np.split(self.values, np.cumsum(self.lengths)[:-1])
