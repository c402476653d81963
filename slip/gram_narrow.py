"""Row sums of the time-side Gram matrix for all windows at once, laid out by lag: fast for short windows.

The row of sample i, seen from time t = i + k, sums |d(i).d(j)| over its past (j from t-n+1 to i-1) and over its
future (j from i+1 to t). With g_l(i) = |d(i).d(i-l)| these are running sums over the lag: past_m(i) =
g_1(i) + ... + g_m(i) with m = n-1-k, and future_k(i) = g_1(i+1) + ... + g_k(i+k). Nothing is ever subtracted, so
a spike that has left the window leaves no trace. Every pass is over contiguous time.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import as_strided

from slip.samples import Floats

TILE = 24  # samples per small matrix product
VALUES_PER_BLOCK = 180_000  # lags x samples held at a time: two such arrays stay near a core
LONGEST_BLOCK = 8_192


def narrow_scores(differences: Floats, window: int) -> Floats:
    """Largest absolute off-diagonal row sum of chi chi^T for every window; (T, taxels) -> (T,).

    O(T window taxels) work; memory of O(window) block lengths, so meant for windows up to a few hundred.
    """
    samples, taxels = differences.shape
    block = min(max(VALUES_PER_BLOCK // window, 4 * window), LONGEST_BLOCK, samples + window)
    tiles = -(-(block + window - 1) // TILE)
    rows = tiles * TILE
    block = rows - window + 1
    blocks = -(-samples // block)
    reach = 2 * window - 2  # samples before a block that its first window's first row looks back on
    held = np.zeros((block + reach, taxels))
    lagged = LaggedProducts(tiles, window, taxels)
    past, future, both = np.zeros((window, rows)), np.empty(rows), np.empty(block)
    scores = np.empty(blocks * block)
    for first in range(0, blocks * block, block):
        _hold(held, differences, first - reach)
        products = lagged.compute(held)
        for lag in range(1, window):
            np.add(past[lag - 1], products[lag], out=past[lag])
        best = scores[first : first + block]
        best[:] = past[window - 1, window - 1 :]
        future[:] = 0.0
        for lag in range(1, window):
            np.add(future[: rows - lag], products[lag, lag:], out=future[: rows - lag])
            start = window - 1 - lag  # the row of sample t - lag, for every t of the block
            np.add(future[start : start + block], past[start, start : start + block], out=both)
            np.maximum(best, both, out=best)
    return scores[:samples]


def _hold(held: Floats, differences: Floats, start: int) -> None:
    """Put the differences from sample `start` on into `held`; zero before the first and after the last."""
    first, last = max(-start, 0), min(len(differences) - start, len(held))
    held[:first] = held[last:] = 0.0
    held[first:last] = differences[start + first : start + last]


class LaggedProducts:
    """|d(i).d(i-l)| for l < window and i in one block, as (window, rows) with time contiguous."""

    def __init__(self, tiles: int, window: int, taxels: int) -> None:
        self._tiles, self._taxels = tiles, taxels
        self._width = width = TILE + window - 1
        # A row pitch of width + 1 and tiles TILE pitches apart make the address of g_l(i) linear in i and in l.
        pitch, item = width + 1, 8
        memory = np.zeros(tiles * TILE * pitch)
        self._gram = as_strided(memory, (tiles, TILE, width), (TILE * pitch * item, width * item, item))
        self._by_lag = as_strided(memory[window - 1 :], (window, tiles * TILE), (-item, pitch * item))
        self._products = np.empty((window, tiles * TILE))
        self._past = window - 1

    def compute(self, differences: Floats) -> Floats:
        """Take (window - 1 + rows, taxels) differences; the returned array is overwritten by the next call."""
        step, item = differences.strides
        rows = as_strided(differences[self._past :], (self._tiles, TILE, self._taxels), (TILE * step, step, item))
        columns = as_strided(differences, (self._tiles, self._taxels, self._width), (TILE * step, item, step))
        np.matmul(rows, columns, out=self._gram)
        return np.abs(self._by_lag, out=self._products)
