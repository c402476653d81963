"""Labelled trials with frames, for the tests of the nets: slip shakes the forces and moves what the camera sees."""

from __future__ import annotations

import numpy as np

from slip.training_trial import TrainingTrial, samples_of_frames

RATE_HZ = 1000.0
FRAMES_PER_S = 30.0


def trial(seed, samples=1500, taxels=4, felt=True, seen=True, side=(20, 24), partial=0):
    """Slip in the second half or so; `felt` by the taxels, `seen` by the camera, or neither."""
    rng = np.random.default_rng(seed)
    onset = samples // 2 + int(rng.integers(-samples // 10, samples // 10))
    slipping = np.arange(samples) >= onset
    force = 0.5 + 1e-3 * rng.standard_normal((samples, taxels))
    if felt:
        force += 2e-2 * slipping[:, None] * rng.standard_normal((samples, taxels))
    state = 2 * slipping.astype(int)
    state[onset - partial : onset] = 1
    at = samples_of_frames(np.arange(0.0, samples / RATE_HZ, 1.0 / FRAMES_PER_S), RATE_HZ)
    at = at[at < samples]
    return TrainingTrial(force, state, film(rng, at, slipping if seen else np.zeros(samples, dtype=bool), side), at)


def film(rng, at, moving, side):
    """A coarse texture that shifts by a pixel from frame to frame while it moves."""
    texture = np.kron(rng.integers(60, 200, (8, 64, 3)), np.ones((4, 4, 1)))[: side[0]]
    shift = np.cumsum(2 * moving[at])
    frames = [texture[:, s : s + side[1]] + rng.normal(0.0, 1.0, (*side, 3)) for s in shift % 200]
    return np.clip(frames, 0, 255).astype(np.uint8)


def stream_with_frames(detector, sequence):
    frames = dict(zip(sequence.frame_samples.tolist(), sequence.frames, strict=True))
    return np.array([detector.update(sample, frame=frames.get(t)) for t, sample in enumerate(sequence.force)])


def view(sequence):
    """What `score` takes of the camera."""
    return {"frames": sequence.frames, "frame_samples": sequence.frame_samples}


def contrast(score, state):
    """Chance that a sample of slip scores above one of stick."""
    slip, stick = score[state == 2], score[state == 0]
    return float((slip[:, None] > stick[None]).mean())
