"""Kernels between feature rows, each entry computed from its own pair alone.

A pair's value has the same bits whichever other rows are in the call, so that one query at a time equals
a batch, copies of an atom tie exactly, and a query that is an atom lies at distance 0. A matrix product
would be faster and keeps none of the three.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from fusion.arrays import FloatArray, frozen
from fusion.settings import is_number

Gamma = float | Literal["scale"]

KERNELS = ("linear", "rbf", "precomputed")
_TOO_SMALL = "X holds values too small to square; scale the features first (StandardScaler)."
SMALLEST = float(np.finfo(np.float64).tiny)  # below it numbers lose digits


def squared_distances(X: FloatArray, Y: FloatArray) -> FloatArray:
    """Squared Euclidean distances of rows of X (q, d) to rows of Y (n, d): (q, n), never negative."""
    return pair_matrix(X, columns_of(Y), squared=True)


def linear_kernel(X: FloatArray, Y: FloatArray) -> FloatArray:
    """Inner products of rows of X (q, d) with rows of Y (n, d): (q, n)."""
    return pair_matrix(X, columns_of(Y), squared=False)


def columns_of(Y: FloatArray) -> FloatArray:
    """Rows of Y (n, d) as the columns (d, n) that `pair_matrix` reads."""
    return frozen(np.asarray(Y).T)


def pair_matrix(X: FloatArray, columns: FloatArray, *, squared: bool, out: FloatArray | None = None) -> FloatArray:
    """Squared distances (squared) or inner products of rows of X (q, d) with `columns` (d, n): (q, n).

    `out`: contiguous array (q, n) to write them into.
    """
    from fusion.pairs import pair_sums

    out = np.empty((len(X), columns.shape[1])) if out is None else out
    pair_sums(frozen(X), frozen(columns), squared, out)
    return out


def squared_norms(X: FloatArray) -> FloatArray:
    """Inner product of each row of X (q, d) with itself: (q,), with the bits of `linear_kernel`."""
    with np.errstate(over="ignore"):
        return np.asarray(np.add.accumulate(X * X, axis=1)[:, -1])


def rbf_kernel(X: FloatArray, Y: FloatArray, gamma: float) -> FloatArray:
    """exp(-gamma |x - y|^2) between rows of X (q, d) and of Y (n, d): (q, n)."""
    values = squared_distances(X, Y)
    values *= -gamma
    return np.asarray(np.exp(values, out=values))


def cosine_normalize(
    K: FloatArray, self_x: FloatArray, self_y: FloatArray, *, out: FloatArray | None = None
) -> FloatArray:
    """k(x, y) / sqrt(k(x, x) k(y, y)); rows and columns whose own value is not positive become 0.

    K is (q, n), `self_x` (q,) holds k(x, x), `self_y` (n,) holds k(y, y). `out`: array (q, n) to write into, such as K.
    """
    values = np.multiply(K, inverse_root(self_x)[:, None], out=out)
    values *= inverse_root(self_y)[None, :]
    return np.asarray(values)


def inverse_root(values: FloatArray) -> FloatArray:
    """1 / sqrt(value), 0 where the value is not positive."""
    positive = values > 0
    return np.where(positive, 1.0 / np.sqrt(np.where(positive, values, 1.0)), 0.0)


def finite_squares(values: FloatArray) -> FloatArray:
    """`values`, which are sums of squares; ValueError where one passed the largest number."""
    if not np.isfinite(values).all():
        raise ValueError("X holds values too large to square; scale the features first (StandardScaler).")
    return values


def check_squares_last(X: FloatArray) -> None:
    """ValueError where the squares of all of X would be lost below the smallest number though X is not 0."""
    largest = float(np.abs(X).max(initial=0.0))
    if largest > 0 and largest * largest < SMALLEST:
        raise ValueError(_TOO_SMALL)


def resolve_gamma(gamma: object, X: FloatArray) -> float:
    """Number for `gamma`: "scale" is 1 / (columns x variance of X), 1 where X is constant, as in SVC.

    ValueError for another gamma, and for values so small that their variance keeps no digits.
    """
    if isinstance(gamma, str) and gamma == "scale":
        variance = float(X.var())
        if variance < SMALLEST and X.min() != X.max():
            raise ValueError(_TOO_SMALL)
        return 1.0 / (X.shape[1] * variance) if variance > 0 else 1.0
    if is_number(gamma) and 0 < gamma < np.inf:  # type: ignore[operator]
        return float(gamma)  # type: ignore[arg-type]
    raise ValueError(f"gamma must be 'scale' or a positive finite number, got {gamma!r}.")
