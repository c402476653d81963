"""Block bootstrap of a rate: overlapping windows are not independent, blocks of many windows nearly are."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slip.samples import Floats

WINDOWS_PER_BLOCK = 10
FEWEST_BLOCKS = 10


def block_means(values: ArrayLike, block: int) -> Floats:
    """Mean of each whole block of (T, ...) values; (blocks, ...). Raises ValueError below ten blocks."""
    array = np.asarray(values, dtype=np.float64)
    count = len(array) // block
    if count < FEWEST_BLOCKS:
        raise ValueError(
            f"expected at least {FEWEST_BLOCKS} blocks of {block} samples ({FEWEST_BLOCKS * block} in all) to "
            f"resample, got {len(array)} samples: record a longer segment"
        )
    blocks = array[: count * block].reshape(count, block, *array.shape[1:])
    means: Floats = blocks.mean(axis=1)
    return means


def resampled_means(means: Floats, draws: int, rng: np.random.Generator) -> Floats:
    """Mean over blocks drawn with replacement, `draws` times; (blocks, ...) -> (draws, ...)."""
    count = len(means)
    weights = rng.multinomial(count, np.full(count, 1.0 / count), size=draws) / count
    return np.tensordot(weights, means, axes=1)


def rate_interval(
    alarms: ArrayLike, window: int, *, level: float = 0.95, draws: int = 2000, seed: int = 0
) -> tuple[float, float, float]:
    """Return (rate, low, high) of the flags (T,) per sample, with a percentile block bootstrap.

    Blocks are 10 windows long. Without any alarm there is nothing to resample: the upper end is then the rate per
    block that as many independent blocks would leave unseen. Raises ValueError where fewer than ten of them fit.
    """
    flags: NDArray[np.bool_] = np.asarray(alarms, dtype=np.bool_)
    means = block_means(flags, WINDOWS_PER_BLOCK * window)
    if not flags.any():
        return 0.0, 0.0, 1.0 - (1.0 - level) ** (1.0 / len(means))
    drawn = resampled_means(means, draws, np.random.default_rng(seed))
    low, high = np.quantile(drawn, [(1.0 - level) / 2.0, (1.0 + level) / 2.0])
    return float(flags.mean()), float(low), float(high)
