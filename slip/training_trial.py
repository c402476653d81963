"""One trial to learn slip from: forces, their true state sample by sample and, where there is a camera, frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slip.samples import Floats, as_sequence

STICK, PARTIAL, GROSS = 0, 1, 2
Integers = NDArray[np.int64]
Images = NDArray[np.uint8]


@dataclass(frozen=True)
class TrainingTrial:
    """Forces (T, taxels) in newtons and the state (T,) of the contact: STICK, PARTIAL or GROSS slip.

    frames : (F, H, W, 3) uint8 or None; frame_samples : (F,) the force sample at which each frame is there.
    Raises ValueError for shapes that do not fit, readings that are not finite or unknown states.
    """

    force: Floats
    state: NDArray[np.int64]
    frames: Images | None = None
    frame_samples: Integers | None = None

    def __post_init__(self) -> None:
        force, _ = as_sequence(self.force)
        state = np.asarray(self.state)
        if state.shape != (len(force),) or not np.isin(state, (STICK, PARTIAL, GROSS)).all():
            raise ValueError(
                f"expected one state of {STICK} (stick), {PARTIAL} (partial) or {GROSS} (gross slip) for each of "
                f"{len(force)} samples, got shape {state.shape} with values {np.unique(state)[:5].tolist()}"
            )
        object.__setattr__(self, "force", force)
        object.__setattr__(self, "state", state.astype(np.int64))
        if self.frames is not None:
            frames, samples = checked_frames(self.frames, self.frame_samples)
            object.__setattr__(self, "frames", frames)
            object.__setattr__(self, "frame_samples", samples)


def checked_frames(frames: ArrayLike, frame_samples: ArrayLike | None) -> tuple[Images, Integers]:
    """Check frames (F, H, W, 3) uint8 and the samples (F,) they come at. Raises ValueError."""
    images = np.asarray(frames)
    if images.ndim != 4 or images.shape[3] != 3 or images.dtype != np.uint8:
        raise ValueError(f"expected frames uint8 of shape (F, H, W, 3), got {images.dtype} of shape {images.shape}")
    samples = np.asarray([] if frame_samples is None else frame_samples)
    if samples.shape != (len(images),) or (len(samples) and samples.dtype.kind not in "iu"):
        raise ValueError(
            f"expected frame_samples, the force sample at which each of {len(images)} frames is there, got "
            f"{samples.dtype} of shape {samples.shape}"
        )
    samples = samples.astype(np.int64)
    if len(samples) and (samples[0] < 0 or (np.diff(samples) <= 0).any()):
        raise ValueError("expected frame_samples that rise from 0 or later, at most one frame for a sample")
    return images, samples


def samples_of_frames(frame_time_s: ArrayLike, rate_hz: float) -> Integers:
    """First force sample at or after each frame's time, both clocks starting at 0; (F,) s -> (F,)."""
    at = np.asarray(frame_time_s, dtype=np.float64) * rate_hz
    return np.ceil(at - 1e-6).astype(np.int64)


def latest_frame(frame_samples: Integers, samples: int) -> Integers:
    """Number of frames that are there at each sample; (F,) -> (samples,)."""
    return np.searchsorted(frame_samples, np.arange(samples), side="right").astype(np.int64)
