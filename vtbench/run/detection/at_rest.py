"""False alarms a sample at rest, before hold-on: what `cfar` was asked for beside what was measured."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import Metric
from vtbench.run.detection.metrics import BOOTSTRAP, DRAWS, LEVEL

UNIT = "false alarms a sample"


def rest_rates(predictions: Mapping[str, NDArray[Any]]) -> Iterator[Metric]:
    """Measured on the rests of the test trials; with `cfar` also what was asked and what the training rests gave.

    None for predictions that were kept without their rests.
    """
    alarms, samples = predictions.get("rest", np.zeros((0, 2), np.int64)).T.astype(np.float64)
    if not samples.sum() > 0:
        return
    alarms, samples = alarms[samples > 0], samples[samples > 0]
    n = len(samples)
    drawn = np.random.default_rng(0).integers(0, n, (DRAWS, n))
    low, high = np.quantile(alarms[drawn].sum(1) / samples[drawn].sum(1), [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    yield _rate("rest_rate", (alarms.sum() / samples.sum(), low, high), n, BOOTSTRAP)
    notes = [note for note in map(json.loads, predictions["choices"].tolist()) if "asked" in note]
    if not notes:
        return
    asked, measured = (np.mean([note[name] for note in notes], axis=0) for name in ("asked", "rest"))
    yield _rate("asked_rate", asked, len(notes), "error of the threshold's own estimate, mean of the folds")
    yield _rate("training_rest_rate", measured, len(notes), "block bootstrap on the training rests, mean of the folds")
    coloured = float(np.mean([bool(note["coloured"]) for note in notes]))
    yield Metric(name="coloured", value=coloured, unit="share of the folds", n=len(notes), groups=len(notes))


def _rate(name: str, measured: Any, n: int, how: str) -> Metric:
    value, low, high = (float(each) for each in measured)
    return Metric(
        name=name,
        value=value,
        unit=UNIT,
        direction="lower",
        n=n,
        groups=n,
        low=min(low, value),
        high=max(high, value),
        interval=how,
    )
