"""What a detector costs: microseconds a sample in a batch and as a stream."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

BATCH_SAMPLES = 30_000
STREAM_SAMPLES = 1_500
REPEATS = 5


def cost_us(detector: Any, force: NDArray[np.floating]) -> tuple[float, float]:
    """(batch, stream) microseconds a sample on forces (T, taxels) repeated to length, the median of five runs."""
    samples = force[np.arange(BATCH_SAMPLES) % len(force)].astype(np.float64)
    batch, stream = [], []
    for _ in range(REPEATS):
        start = time.perf_counter_ns()
        detector.score(samples)
        batch.append((time.perf_counter_ns() - start) / len(samples))
        detector.reset()
        start = time.perf_counter_ns()
        for row in samples[:STREAM_SAMPLES]:
            detector.update(row)
        stream.append((time.perf_counter_ns() - start) / STREAM_SAMPLES)
    detector.reset()
    return float(np.median(batch)) / 1e3, float(np.median(stream)) / 1e3
