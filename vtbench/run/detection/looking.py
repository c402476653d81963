"""What a detector is given of a trial: forces, and where it looks at the camera too, frames."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import slip
from vtbench.tasks.base import NotPossibleError
from vtbench.tasks.slides import SlideData

WITH_FRAMES = ("neural-force-frames",)

Force = NDArray[np.floating]


def looks(detector: Any) -> bool:
    """Whether the detector takes frames beside forces."""
    return isinstance(detector, slip.NeuralForceFrames)


def frames_of(data: SlideData, trial: int) -> dict[str, NDArray[Any]]:
    """Frames of a trial and the samples that they come with, as a detector's `score` takes them.

    Raises:
        NotPossibleError: the trial has no frames.
    """
    frames, times_s = data.frames(trial)
    if len(frames) == 0:
        raise NotPossibleError("the trials were kept without frames, which this detector looks at")
    return {"frames": frames, "frame_samples": slip.samples_of_frames(times_s, data.truth[trial].rate_hz)}


def trial_scores(detector: Any, data: SlideData, trial: int, force: Force) -> NDArray[np.float64]:
    """Scores (T,) of one trial's forces (T, taxels), with its frames where the detector looks at them."""
    return np.asarray(detector.score(force, **(frames_of(data, trial) if looks(detector) else {})))
