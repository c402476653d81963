"""Normal noise for the pixels of a frame, sixteen random bits a value: a tenth of the cost of drawing floats."""

from __future__ import annotations

from functools import lru_cache
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

_BITS = 16


@lru_cache(maxsize=1)
def normal_table() -> NDArray[np.float32]:
    """(65536,) float32: means of a standard normal variable over as many equally likely intervals, ascending.

    A number of 16 random bits picks a value; mean 0 exactly, variance 1 - 1.5e-6, kurtosis 3 - 1.8e-4, and the last
    intervals, whose means are -4.4 and 4.4, stand for the tails beyond 4.2. Before it is rounded to grey levels, noise
    of one grey level is thus resolved to 4e-5 of a level.
    """
    count = 2**_BITS
    normal = NormalDist()
    edges = np.array([normal.inv_cdf(number / count) for number in range(1, count // 2)] + [0.0])
    # the mean of z over an interval of probability 1 / count is count * (density at its start - density at its end)
    density = np.concatenate(([0.0], np.exp(-(edges**2) / 2) / np.sqrt(2 * np.pi)))
    lower = -count * np.diff(density)
    table = np.concatenate((lower, -lower[::-1])).astype(np.float32)
    table.setflags(write=False)
    return table


def random_words(rng: np.random.Generator | None, values: int) -> NDArray[np.uint64]:
    """Random words of 64 bits, enough for `values` numbers of 16 bits; zeros where `rng` is None."""
    words = -(-values * _BITS // 64)
    return np.zeros(words, np.uint64) if rng is None else rng.integers(0, 2**64, words, dtype=np.uint64)
