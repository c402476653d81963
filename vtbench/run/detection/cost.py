"""What a detector costs: microseconds a sample in a batch and as a stream."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

BATCH_SAMPLES = 30_000
STREAM_SAMPLES = 1_500
REPEATS = 5


def cost_us(
    detector: Any, force: NDArray[np.floating], look: Mapping[str, NDArray[Any]] | None = None
) -> tuple[float, float]:
    """(batch, stream) microseconds a sample on forces (T, taxels) repeated to length, the median of five runs.

    `look` are the frames of the same trial and the samples that they come with: then the trial as it is.
    """
    samples = force.astype(np.float64)
    if look is None:
        samples = samples[np.arange(BATCH_SAMPLES) % len(force)]
    at = {} if look is None else dict(zip(look["frame_samples"].tolist(), look["frames"], strict=True))
    batch, stream = [], []
    for _ in range(REPEATS):
        start = time.perf_counter_ns()
        detector.score(samples, **(look or {}))
        batch.append((time.perf_counter_ns() - start) / len(samples))
        detector.reset()
        start = time.perf_counter_ns()
        for number, row in enumerate(samples[:STREAM_SAMPLES]):
            detector.update(row, **({"frame": at[number]} if number in at else {}))
        stream.append((time.perf_counter_ns() - start) / min(STREAM_SAMPLES, len(samples)))
    detector.reset()
    return float(np.median(batch)) / 1e3, float(np.median(stream)) / 1e3
