"""Slip scores that a model gave -> predictions of a slip task, on the terms of every other detector."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtbench.run.detection.detect import DetectionWork, Run, packed, run_detector, test_traces
from vtbench.run.detection.methods import BASELINE
from vtbench.run.detection.thresholds import Fitted, earlier_slips

RULE = "prior"
"""The only rule whose threshold is found from scores alone."""


class Recorded:
    """A detector that remembers: the scores a model gave for each trial, found again by the trial's forces."""

    settling = 0

    def __init__(self) -> None:
        self._scores: dict[bytes, NDArray[np.float32]] = {}

    def score(self, force: ArrayLike) -> NDArray[np.float64]:
        """Scores (T,) of a trial that was given to the model; KeyError for another."""
        return self._scores[_name(force)].astype(np.float64)

    def remember(self, force: ArrayLike, score: NDArray[np.float32]) -> None:
        """Add a trial."""
        self._scores[_name(force)] = score


def _name(force: ArrayLike) -> bytes:
    return hashlib.sha256(np.ascontiguousarray(force, np.float32).tobytes()).digest()


def slip_predictions(
    scores: Sequence[NDArray[np.float32]], work: DetectionWork, us_per_sample: float
) -> dict[str, NDArray[Any]]:
    """Predictions as a cell of the grid keeps them, the energy baseline beside them.

    Raises:
        NotPossibleError: scores that give no threshold on the training slips of a fold.
    """
    detector = Recorded()
    for trial, force in work.data.each_force(np.arange(len(work.data))):
        detector.remember(force, scores[trial].ravel())
    fitted, traces = [], []
    for fold in work.split.folds:
        betas = earlier_slips(detector, RULE, work.data, fold.train)
        beta = float(np.sort(betas)[len(betas) // 2])
        note = {"beta": beta, "lowest": min(betas), "highest": max(betas), "slips": len(betas)}
        fitted.append(Fitted(detector, beta, 1.0, note))
        traces += test_traces(fitted[-1], work, fold)
    own = Run(fitted, traces, 0.0, 0)
    beside = run_detector(BASELINE, work)
    return packed(work, own, beside, (us_per_sample, us_per_sample))
