"""Vectors in compiled loops against the same arithmetic in NumPy."""

import numpy as np
from numba import njit

from fusion.lanes import (
    FOLD,
    TILE,
    less_product,
    load,
    peaks,
    prefetch,
    product,
    spread,
    spread_fold,
    store,
    where_larger,
)


@njit
def pass_over(a, b, factor, out, top):
    prefetch(a, 10**6)
    best = spread_fold(-1.0)
    for p in range(0, len(a), TILE):
        values = product(less_product(load(a, p), spread(factor), load(b, p)), load(b, p))
        store(out, p, values)
        here = peaks(values)
        best = where_larger(here, best, here, best)
    store(top, 0, best)


def test_arithmetic_and_largest_sizes_are_those_of_lone_numbers_and_nan_is_never_larger():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 5 * TILE)) * 10.0 ** rng.integers(-200, 100, size=(2, 5 * TILE))
    a[[0, FOLD + 1, 3 * TILE + 2]] = np.nan
    a[5::FOLD] = np.nan
    out, top = np.empty_like(a), np.empty(FOLD)
    pass_over(a, b, 0.3, out, top)
    wanted = (a - 0.3 * b) * b
    np.testing.assert_array_equal(out, wanted)
    expected = np.where(np.isnan(wanted), -1.0, np.abs(wanted)).reshape(-1, FOLD).max(axis=0)
    np.testing.assert_array_equal(top, expected)
    assert top[5] == -1.0
