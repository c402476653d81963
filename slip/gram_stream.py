"""Row sums of the Gram matrices kept up to date sample by sample, in O(window taxels) work and memory."""

from __future__ import annotations

import numpy as np

from slip.samples import Floats


class TimeGram:
    """Absolute off-diagonal row sums of chi chi^T (window x window) over the last `window` differences.

    The Gram matrix itself is never stored: a new sample brings one row of dot products, and the row of the
    leaving sample is computed once more to be taken off. A row lives for one window, so what it carries of
    rounding came in within the last two windows; Kahan's compensation keeps that free of the window's length.
    """

    def __init__(self, window: int, taxels: int) -> None:
        self._ring = np.zeros((taxels, window))
        self._pair = np.zeros((2, taxels))
        self._products = np.empty((2, window))
        self._sums = np.zeros(window)
        self._lost = np.zeros(window)
        self._slot = 0

    def push(self, difference: Floats) -> float:
        """Take the next difference (taxels,); return the largest row sum."""
        slot, pair, products = self._slot, self._pair, self._products
        sums, lost = self._sums, self._lost
        pair[0], pair[1] = self._ring[:, slot], difference
        np.matmul(pair, self._ring, out=products)
        np.abs(products, out=products)
        products[:, slot] = 0.0
        leaving, entering = products
        new_row = float(entering.sum())
        change = np.subtract(entering, leaving, out=leaving)
        change -= lost
        total = sums + change
        np.subtract(total, sums, out=lost)
        lost -= change
        total[slot], lost[slot] = new_row, 0.0
        self._sums = total
        self._ring[:, slot] = difference
        self._slot = (slot + 1) % len(total)
        return max(float(total.max()), 0.0)


class TaxelGram:
    """Absolute off-diagonal row sums of chi^T chi (taxels x taxels) over the last `window` differences.

    Beside the running matrix a fresh one gathers the products since the last restart; after each window the
    fresh one, which never lost anything, takes the running one's place, so no rounding outlives two windows.
    """

    def __init__(self, window: int, taxels: int) -> None:
        self._ring = np.zeros((window, taxels))
        self._running = np.zeros((taxels, taxels))
        self._fresh = np.zeros((taxels, taxels))
        self._slot = 0

    def push(self, difference: Floats) -> float:
        """Take the next difference (taxels,); return the largest row sum."""
        entering, leaving = _cross_products(difference), _cross_products(self._ring[self._slot])
        self._fresh += entering
        self._running += entering - leaving
        self._ring[self._slot] = difference
        self._slot = (self._slot + 1) % len(self._ring)
        if self._slot == 0:
            self._running, self._fresh = self._fresh, np.zeros_like(self._fresh)
        return float(np.abs(self._running).sum(axis=1).max())


def _cross_products(difference: Floats) -> Floats:
    products = np.multiply.outer(difference, difference)
    np.fill_diagonal(products, 0.0)
    return products
