"""In which order and company a model meets the samples: at random, and then otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

BATCH, AGAIN_BATCH = 32, 7
MOST_SCORES_AGAIN = 100_000
AGAIN = 64
TIMED = (1, 100)
ROTATING = 4
TIMING_BUDGET_S = 2.0

Batches = list[list[int]]


def batches(samples: NDArray[np.int64], lengths: NDArray[np.int64] | None, size: int) -> Batches:
    """Samples in batches of at most `size`, in their order; those in time only with others of the same length."""
    found: Batches = []
    open_batches: dict[int, list[int]] = {}
    for sample in samples.tolist():
        length = 1 if lengths is None else int(lengths[sample])
        batch = open_batches.get(length)
        if batch is None or len(batch) == size:
            batch = open_batches[length] = []
            found.append(batch)
        batch.append(sample)
    return found


def again(n: int, lengths: NDArray[np.int64] | None, rng: np.random.Generator) -> Batches:
    """Some samples once more in a new order and in smaller batches; of long series fewer."""
    chosen = rng.permutation(n)[:AGAIN]
    if lengths is not None:
        chosen = chosen[: max(2, int(np.searchsorted(np.cumsum(lengths[chosen]), MOST_SCORES_AGAIN)))]
    return batches(chosen, lengths, AGAIN_BATCH)


def timing(n: int, lengths: NDArray[np.int64] | None, time_s: float, in_time: bool) -> list[Mapping[str, Any]]:
    """Calls to be timed: one sample at a time, and 100 where the task gives one score a sample."""
    alike = np.arange(n)
    if lengths is not None:
        values, counts = np.unique(lengths, return_counts=True)
        alike = np.flatnonzero(lengths == values[counts.argmax()])
    plans: list[Mapping[str, Any]] = []
    for size in TIMED[:1] if in_time else TIMED:
        rounds = [np.resize(np.roll(alike, -size * at), size).tolist() for at in range(ROTATING)]
        plans.append({"batch": size, "batches": rounds, "budget_s": min(TIMING_BUDGET_S, time_s / 10)})
    return plans


def rows_of(parts: Sequence[Batches], lengths: NDArray[np.int64] | None, in_time: bool) -> int:
    """Rows of scores in all batches together."""
    samples = [sample for part in parts for batch in part for sample in batch]
    return int(lengths[samples].sum()) if in_time and lengths is not None else len(samples)
