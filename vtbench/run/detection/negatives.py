"""Each kind of trial without slip by itself: how late is the alarm when only these disturb the detector?"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from leaderboard.record import Metric
from slip.alarms import AlarmRule, Trial
from slip.delay import DelayAtRate, delay_at_rate, paired_delay_interval
from slip.roc import roc_by_trial
from vtbench.run.detection.metrics import BOOTSTRAP, LEVEL, delay_metric, difference, expected_alarms
from vtbench.tasks.slides import RECOVERED, SlideTruth

DRAWS = 200
_kept: dict[tuple[str, float], DelayAtRate] = {}


def against_each_kind(
    own: Sequence[Trial], beside: Sequence[Trial], truth: Sequence[SlideTruth], rate: float, rule: AlarmRule
) -> Iterator[Metric]:
    """Delay, slips found and the pairing with the baseline at a rate of false alarms, and the ROC area, by kind.

    The rate is that over the trials with slip and those of one kind without.
    """
    kinds = list(dict.fromkeys(what.kind for what in truth if what.onset is None and what.kind != RECOVERED))
    for kind in kinds if len(kinds) > 1 else ():
        chosen = [at for at, what in enumerate(truth) if what.onset is not None or what.kind == kind]
        ours = delay_at_rate([own[at] for at in chosen], rate, rule, level=LEVEL, draws=DRAWS)
        theirs = baseline_delay([beside[at] for at in chosen], rate, rule)
        n = len(ours.delays_s)
        shared: dict[str, Any] = {"n": n, "groups": n, "interval": BOOTSTRAP}
        at = f"@{rate:g}[negatives={kind}]"
        low, high = ours.detected_interval
        yield expected_alarms(at, rate, ours, len(chosen))
        yield Metric(name=f"detected{at}", value=ours.detected, low=low, high=high, **shared)
        yield delay_metric(f"delay_ms{at}", ours.median_s, ours.median_interval_s, shared)
        paired = paired_delay_interval(ours, theirs, LEVEL)
        yield delay_metric(f"delay_minus_energy_ms{at}", difference(ours, theirs), paired, shared)
        alike = [own[at] for at in chosen if truth[at].comparable]
        if any(trial.onset is None for trial in alike):
            yield area_metric(f"roc_area[negatives={kind}]", alike, rule)


def baseline_delay(trials: Sequence[Trial], rate: float, rule: AlarmRule) -> DelayAtRate:
    """The baseline's delay; remembered, because every detector on the same trials asks for it."""
    content = hashlib.sha256(np.concatenate([trial.score for trial in trials]).tobytes())
    content.update(repr([(trial.onset, trial.end, rule) for trial in trials]).encode())
    name = (content.hexdigest(), rate)
    if name not in _kept:
        _kept[name] = delay_at_rate(trials, rate, rule, level=LEVEL, draws=DRAWS)
    return _kept[name]


def area_metric(name: str, trials: Sequence[Trial], rule: AlarmRule) -> Metric:
    """Area of the ROC by trial."""
    roc = roc_by_trial(trials, rule, level=LEVEL)
    low, high = min(roc.area_interval[0], roc.area), max(roc.area_interval[1], roc.area)
    n = len(trials)
    return Metric(name=name, value=roc.area, unit="area", n=n, groups=n, low=low, high=high, interval=BOOTSTRAP)
