"""Row sums of the time-side Gram matrix for windows too long to hold all lags of a block at once."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import as_strided

from slip.samples import Floats

ROWS = 16  # samples whose products are held at a time


def wide_scores(differences: Floats, window: int) -> Floats:
    """Largest absolute off-diagonal row sum of chi chi^T for every window; (T, taxels) -> (T,).

    Rows come 16 at a time, each with its products over window - 1 samples before and after it; running sums
    outwards from the diagonal give the row's sum for every window that holds it. O(T window taxels) work,
    O(window (taxels + 16)) memory beside the sequence. Nothing is subtracted.
    """
    samples, taxels = differences.shape
    reach = window - 1
    rows = -(-samples // ROWS) * ROWS
    padded = np.zeros((rows + 2 * reach, taxels))
    padded[reach : reach + samples] = differences
    scores = np.zeros(rows + reach)
    gram = np.empty((ROWS, ROWS + 2 * reach))
    item = gram.itemsize
    centred = as_strided(gram, (ROWS, 2 * reach + 1), (gram.strides[0] + item, item))  # diagonal at `reach`
    past, future = np.zeros((ROWS, window)), np.zeros((ROWS, window))
    by_time = np.zeros((ROWS, ROWS + reach))  # outside a row's own band stays 0, below every score
    band = as_strided(by_time, (ROWS, window), (by_time.strides[0] + item, item))
    for first in range(0, rows, ROWS):
        block = padded[first : first + ROWS + 2 * reach]
        np.matmul(block[reach : reach + ROWS], block.T, out=gram)
        np.abs(gram, out=gram)
        np.cumsum(centred[:, reach - 1 :: -1], axis=1, out=past[:, 1:])
        np.cumsum(centred[:, reach + 1 :], axis=1, out=future[:, 1:])
        np.add(future, past[:, ::-1], out=band)
        reached = scores[first : first + ROWS + reach]
        np.maximum(reached, by_time.max(axis=0), out=reached)
    return scores[:samples]
