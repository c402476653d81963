"""Force sequences with known properties, for the tests of the slip detectors."""

from __future__ import annotations

import numpy as np


def rest(samples, taxels=16, seed=0, noise_n=1e-3, level_n=0.3):
    rng = np.random.default_rng(seed)
    return level_n * rng.uniform(0.5, 1.5, taxels) + noise_n * rng.standard_normal((samples, taxels))


def eventful(samples, taxels=16, seed=0, spike_at=None):
    """Rest, a load ramp, a vibrating slip, and where asked one sample of 1e6 N."""
    force = rest(samples, taxels, seed)
    rng = np.random.default_rng([seed, 1])
    third = samples // 3
    force[third : 2 * third] += np.linspace(0.0, 2.0, third)[:, None] * rng.uniform(0.2, 1.0, taxels)
    force[2 * third :] += 2.0 * rng.uniform(0.2, 1.0, taxels)
    shake = 0.05 * rng.standard_normal((samples - 2 * third, taxels))
    force[2 * third :] += shake * (rng.uniform(size=(samples - 2 * third, 1)) < 0.5)
    if spike_at is not None:
        force[spike_at] += 1e6 * rng.uniform(0.1, 1.0, taxels)
    return force


def stream(detector, force):
    return np.array([detector.update(sample) for sample in force])


def disagreement(streamed, batch, window):
    """Largest difference over the largest score in the last two windows; 0/0 counts as 0, and so does nothing."""
    if len(batch) == 0:
        return 0.0
    span = 2 * window
    padded = np.concatenate([np.zeros(span - 1), batch])
    scale = np.lib.stride_tricks.sliding_window_view(padded, span).max(axis=1)
    apart = np.abs(streamed - batch)
    assert not (apart[scale == 0.0] > 0.0).any()
    return float((apart[scale > 0.0] / scale[scale > 0.0]).max(initial=0.0))
