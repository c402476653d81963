"""`prior`: the threshold beta from one earlier slip, as in the FVSight paper."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from slip.calibrate import Calibration
from slip.detector import DifferenceDetector
from slip.samples import Floats


def prior(
    detector: DifferenceDetector, force: ArrayLike, slip: tuple[int, int], *, reached: float = 0.9
) -> Calibration:
    """Take beta as the score that the share `reached` of an earlier slip's samples attain.

    force : (T, taxels) newtons of one trial; slip : its first sample and the one after its last. The paper says
    only that a prior slip determines beta; the share is our reading. The first `detector.settling` samples of the
    slip and those just after it, whose windows hold both states, are left out where enough remain.
    Raises ValueError for a slip outside the sequence or a slip that leaves no score.
    """
    scores = detector.score(force)
    beta = beta_of_slip(scores, slip, detector.settling, reached)
    begin, end = slip
    outside = np.concatenate([scores[:begin], scores[end + detector.settling :]])
    alarms = float((outside >= beta).mean()) if len(outside) else float("nan")
    return Calibration(detector, beta, "prior", alarms, float("nan"), float("nan"))


def beta_of_slip(scores: Floats, slip: tuple[int, int], settling: int, reached: float = 0.9) -> float:
    """Beta of `prior` from the scores (T,) of the earlier slip's trial, however they came about; same errors."""
    begin, end = slip
    if not 0 <= begin < end <= len(scores):
        raise ValueError(f"expected a slip within the {len(scores)} samples of the trial, got {slip}")
    if not 0.0 < reached <= 1.0:
        raise ValueError(f"expected `reached` to be a share in (0, 1], got {reached!r}")
    filled = begin + settling
    during = scores[filled if filled < end else begin : end]
    beta = float(np.quantile(during, 1.0 - reached, method="lower"))
    if not beta > 0.0:
        raise ValueError("the earlier slip leaves a score of 0: beta would call every sample slip")
    return beta
