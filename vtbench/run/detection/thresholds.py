"""A detector and its threshold, from training trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import slip
from vtbench.run.detection.learning import LEARNT, learnt
from vtbench.run.detection.looking import looks, trial_scores
from vtbench.tasks.base import NotPossibleError
from vtbench.tasks.slides import SlideData

REST_SAMPLES = 40_000
"""Of training rests, at most: the noise is known to a percent by then."""

HIGH_BAND = 0.15

Force = NDArray[np.floating]


@dataclass(frozen=True)
class Fitted:
    """A detector, beta, and what is known of it, in JSON values.

    `unit` is what its scores are divided by before they are kept: beta where each fold has a detector of its own.
    """

    detector: Any
    beta: float
    unit: float
    note: dict[str, Any]


def parameters(name: str, window: int, rate_hz: float) -> dict[str, Any]:
    """Arguments of a detector; the high band begins at the same share of the rate, 150 Hz at 1 kHz."""
    high = {"rate_hz": rate_hz, "cutoff_hz": HIGH_BAND * rate_hz} if name == "spectral" else {}
    return {"window": window, **high}


def seen(force: Force, feed: str) -> Force:
    """What the detector is fed: the taxels (T, taxels), or with the feed `total-force` their sum (T, 1)."""
    return force.sum(1, keepdims=True, dtype=np.float64) if feed == "total-force" else force


def fit(name: str, feed: str, data: SlideData, train: NDArray[np.int64], cfar_rate: float, window: int = 50) -> Fitted:
    """Make the detector `name` and find beta from the training trials by the rule that the feed names.

    Raises:
        NotPossibleError: no training trial to learn the threshold from.
    """
    if name in LEARNT:
        detector = learnt(name, data, train)
    else:
        detector = slip.make_detector(name, **parameters(name, window, data.truth[int(train[0])].rate_hz))
    if feed == "cfar":
        if looks(detector):
            raise NotPossibleError("cfar simulates rest noise of the forces; what the camera sees at rest it does not")
        rest = rest_forces(data, train)
        try:
            found = slip.cfar(detector, rest, cfar_rate)
        except ValueError as error:
            raise NotPossibleError(f"the training rests do not give a threshold: {error}") from None
        note = {
            "beta": found.beta,
            "asked": [found.asked_rate, found.low, found.high],
            "rest_rate": found.rest_rate,
            "rest": [found.rest_rate, found.rest_low, found.rest_high],
            "coloured": found.coloured,
            "cfar": str(found),
        }
        return Fitted(found.detector, found.beta, found.beta, note)
    betas = earlier_slips(detector, feed, data, train)
    beta = float(np.sort(betas)[len(betas) // 2])
    return Fitted(detector, beta, 1.0, {"beta": beta, "lowest": min(betas), "highest": max(betas), "slips": len(betas)})


def earlier_slips(detector: Any, feed: str, data: SlideData, train: NDArray[np.int64]) -> list[float]:
    """Beta of `slip.prior` with each training slip as the earlier one; a slip that scores 0 throughout gives none."""
    betas = []
    for trial, force in data.each_force([t for t in train.tolist() if data.truth[t].onset is not None]):
        truth = data.truth[trial]
        assert truth.onset is not None
        assert truth.end is not None
        try:
            scores = trial_scores(detector, data, trial, seen(force, feed))
            betas.append(slip.beta_of_slip(scores, (truth.onset, truth.end), detector.settling))
        except ValueError:
            continue
    if not betas:
        raise NotPossibleError("no training trial holds a slip that the detector scores, so beta cannot be found")
    return betas


def rest_forces(data: SlideData, train: NDArray[np.int64]) -> Force:
    """Rests of the training trials one after another, (T, taxels), brought to one mean so that no seam is a jump.

    Raises:
        NotPossibleError: no training trial begins with a rest.
    """
    parts: list[Force] = []
    length = 0
    for trial, force in data.each_force([t for t in train.tolist() if data.truth[t].rest > 0]):
        parts.append(force[: data.truth[trial].rest].astype(np.float64))
        length += len(parts[-1])
        if length >= REST_SAMPLES:
            break
    if not parts:
        raise NotPossibleError("no training trial begins with a rest, so the noise is not known")
    return joined(parts)


def joined(parts: Sequence[Force]) -> Force:
    """Segments (T_i, taxels) as one, each shifted to the mean of the first."""
    level = parts[0].mean(axis=0)
    return np.concatenate([part - part.mean(axis=0) + level for part in parts])
