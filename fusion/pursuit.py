"""The compiled loop of kernel orthogonal matching pursuit: one query after the other, all steps fused.

One partial Cholesky factorisation per query: row j of `basis` holds the inner products of all atoms with the
j-th orthonormal direction, so a step reads one Gram row and j earlier basis rows, tile by tile, writes row j,
updates the correlations by bounded numbers even where the coefficients are huge (wide kernels), and looks for
the largest of them, all in one pass. A chosen atom's correlation is NaN from then on, which is never larger.
Nothing is shared between queries, so that no cut of them into chunks or threads can change a bit.
"""

from __future__ import annotations

import math

import numpy as np

from fusion.arrays import FloatArray, IntArray
from fusion.compiled import compiled
from fusion.gram import Gram
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
from fusion.pairs import gram_row

EPS = float(np.finfo(np.float64).eps)
DOUBTFUL_PIVOT = 1e-4  # of the atom's squared norm: from here on rounding in the pivot is estimated
AHEAD = 256  # atoms: how far ahead of its use a Gram row is fetched


@compiled
def pursue(
    gram: Gram,
    kernels: FloatArray,
    scales: FloatArray,
    tolerances: FloatArray,
    start: int,
    stop: int,
    basis: FloatArray,
    working: FloatArray,
    indices: IntArray,
    coefs: FloatArray,
    energy: FloatArray,
) -> None:
    """Write the codes of the queries from `start` to `stop` into `indices`, `coefs` and `energy`.

    `kernels` (M, q, n) holds M modalities' values of q queries with n atoms, `scales` (M, n) the factor on
    each atom's correlation (0 bars the atom), `tolerances` (k,) the least part of an atom's squared norm outside
    those before it. `basis` (M, k, w) and `working` (2 M + 1, w) are `scratch`.
    `indices` (q, k) comes filled with -1, `coefs` (M, q, k) and `energy` (M, q) with 0.
    """
    n_modalities, n_queries, n = kernels.shape
    k, width = indices.shape[1], working.shape[1]
    if width % TILE or width < n:
        raise ValueError("basis and working must come from scratch(): whole tiles of atoms")
    lower = np.zeros((n_modalities, k, k))
    projections = np.empty((n_modalities, k))
    smallest = np.empty(n_modalities)
    leaders = np.empty(2 * FOLD)
    # flat views, taken once: a view taken in the loop costs as much as a short row
    flat, directions, factors = working.reshape(-1), basis.reshape(-1), lower.reshape(-1)
    rows, queries, diagonals = gram.stored.reshape(-1), kernels.reshape(-1), gram.diagonals.reshape(-1)
    stored = len(rows) > 0
    row = np.empty(0 if stored else n)
    unit = n_modalities == 1
    for m in range(n_modalities):
        working[n_modalities + m, n:] = 0.0
        for p in range(n):
            working[n_modalities + m, p] = scales[m, p]
            unit = unit and scales[m, p] == 1.0
    score = 0 if unit else 2 * n_modalities * width  # where sizes are correlations they are read where they lie
    for query in range(start, stop):
        for m in range(n_modalities):
            smallest[m] = 1.0
            _begin(queries, (m * n_queries + query) * n, n, flat, m * width, width, leaders)
        if not unit:
            _score(working, leaders)
        first = 0.0
        taken = 0
        for step in range(k):
            best, atom = _leader(leaders, flat, score)
            if step == 0:
                first = best
            if not (best > 8.0 * EPS * first and best > 0.0):
                break
            for m in range(n_modalities):
                projections[m, step] = flat[m * width + atom]
            flat[atom] = math.nan
            independent = False
            for m in range(n_modalities):
                own = (m * k + step) * k
                place = _place(atom, 0, k) + m * k * width
                diagonal = pivot = diagonals[m * n + atom]
                for earlier in range(step):
                    factor = directions[place + earlier * TILE]
                    factors[own + earlier] = factor
                    pivot -= factor * factor
                usable = diagonal > 0.0 and pivot > tolerances[step] * diagonal
                if usable:
                    smallest[m] = min(smallest[m], pivot / diagonal)
                    if smallest[m] < DOUBTFUL_PIVOT:
                        usable = pivot > _pivot_noise(lower[m], gram.diagonals[m], indices[query], atom, step)
                independent = independent or usable
                root = math.sqrt(pivot) if usable else 1.0
                projection = projections[m, step] / root if usable else 0.0
                factors[own + step] = root
                projections[m, step] = projection
                energy[m, query] += projection * projection
                if step + 1 < k:
                    inverse = 1.0 / root if usable else 0.0
                    if stored:
                        at = (m * n + atom) * n
                        _advance(
                            rows, at, n, directions, k, factors, m, step, inverse, projection, flat, width, leaders
                        )
                    else:
                        gram_row(gram, m, atom, row)
                        _advance(row, 0, n, directions, k, factors, m, step, inverse, projection, flat, width, leaders)
            if not independent:
                break
            indices[query, step] = atom
            taken += 1
            if not unit and step + 1 < k:
                _score(working, leaders)
        for m in range(n_modalities):
            _back_substitute(lower[m], projections[m], taken, coefs[m, query])


@compiled
def _place(atom: int, row: int, k: int) -> int:
    """Where `atom`'s value of basis row `row` lies: the k rows of one tile of atoms lie together."""
    return (atom // TILE * k + row) * TILE + atom % TILE


@compiled
def _begin(
    queries: FloatArray, at: int, n: int, working: FloatArray, base: int, width: int, leaders: FloatArray
) -> None:
    """Copy a query's kernel values, from place `at` on, to the correlations at `base`; NaN behind the last atom."""
    best, where = spread_fold(-1.0), spread_fold(0.0)
    whole = n - n % TILE
    for p in range(whole, width):
        working[base + p] = queries[at + p] if p < n else math.nan
    for p in range(0, width, TILE):
        values = load(queries, at + p) if p < whole else load(working, base + p)
        prefetch(queries, at + p + AHEAD)
        store(working, base + p, values)
        top = peaks(values)
        where = where_larger(top, best, spread_fold(float(p)), where)
        best = where_larger(top, best, top, best)
    store(leaders, 0, best)
    store(leaders, FOLD, where)


@compiled
def _advance(
    source: FloatArray,
    at: int,
    n: int,
    basis: FloatArray,
    k: int,
    factors: FloatArray,
    m: int,
    step: int,
    inverse: float,
    projection: float,
    working: FloatArray,
    width: int,
    leaders: FloatArray,
) -> None:
    """Write basis row `step`, the part of the Gram row outside the earlier rows, and take it off the query.

    The Gram row's n values lie in `source` from place `at` on. `leaders` receives the largest sizes of the new
    correlations in each of eight columns of atoms, and the tiles where they lie.
    """
    best, where = spread_fold(-1.0), spread_fold(0.0)
    scale, part = spread(inverse), spread(projection)
    whole = n - n % TILE
    base, own = m * k * width, (m * k + step) * k
    last = base + _place(whole, step, k)
    if whole < n:
        for p in range(TILE):
            basis[last + p] = source[at + whole + p] if whole + p < n else 0.0
    onward = step % 2 == 1  # each step begins where the one before ended: that is still in the first-level cache
    for turn in range(0, width, TILE):
        p = turn if onward else width - TILE - turn
        values = load(source, at + p) if p < whole else load(basis, last)
        prefetch(source, at + p + (AHEAD if onward else -AHEAD))
        row = base + p * k
        for earlier in range(step):
            values = less_product(values, spread(factors[own + earlier]), load(basis, row))
            row += TILE
        values = product(values, scale)
        store(basis, row, values)
        values = less_product(load(working, m * width + p), part, values)
        store(working, m * width + p, values)
        top = peaks(values)
        here = spread_fold(float(p))  # of equal ones the lower, whichever came first
        where = where_larger(top, best, here, where) if onward else where_larger(best, top, where, here)
        best = where_larger(top, best, top, best)
    store(leaders, 0, best)
    store(leaders, FOLD, where)


@compiled
def _score(working: FloatArray, leaders: FloatArray) -> None:
    """Write each atom's size of correlation over the modalities into the last row, and `leaders` as `_advance` does.

    `working` (2 M + 1, w) holds the correlations, their factors and the sizes.
    """
    best, where = spread_fold(-1.0), spread_fold(0.0)
    n_modalities, width = len(working) // 2, working.shape[1]
    score = working[2 * n_modalities]
    for p in range(0, width, TILE):
        for q in range(p, p + TILE):
            score[q] = abs(working[0, q]) * working[n_modalities, q]
        if n_modalities > 1:
            for q in range(p, p + TILE):
                score[q] *= score[q]
            for m in range(1, n_modalities):
                for q in range(p, p + TILE):
                    size = working[m, q] * working[n_modalities + m, q]
                    score[q] += size * size
            for q in range(p, p + TILE):
                score[q] = math.sqrt(score[q])
        top = peaks(load(score, p))
        where = where_larger(top, best, spread_fold(float(p)), where)
        best = where_larger(top, best, top, best)
    store(leaders, 0, best)
    store(leaders, FOLD, where)


@compiled
def _leader(leaders: FloatArray, working: FloatArray, score: int) -> tuple[float, int]:
    """The largest of the sizes at `score` (their signs aside) and the lowest index that has it; -1 where it is 0."""
    best = leaders[0]
    for column in range(1, FOLD):
        best = max(best, leaders[column])
    lowest = -1
    for column in range(FOLD):
        if leaders[column] == best and best > 0.0:
            p = int(leaders[FOLD + column]) + column
            while abs(working[score + p]) != best:
                p += FOLD
            lowest = p if lowest < 0 else min(lowest, p)
    return best, lowest


@compiled
def _pivot_noise(lower: FloatArray, diagonals: FloatArray, chosen: IntArray, atom: int, step: int) -> float:
    """Rounding error to expect in the pivot of `atom`, the next of a query.

    With w the chosen atoms' coefficients that best rebuild the atom, errors of eps in the Gram matrix reach
    the pivot as eps (|d_i| + sum_a |w_a| |d_a|)^2.
    """
    w = np.zeros(step)
    _back_substitute(lower, lower[step], step, w)
    size = math.sqrt(diagonals[atom])
    for place in range(step):
        size += abs(w[place]) * math.sqrt(max(diagonals[chosen[place]], 0.0))
    return 8.0 * EPS * (size * size)


@compiled
def _back_substitute(lower: FloatArray, values: FloatArray, size: int, x: FloatArray) -> None:
    """Write the solution of L' x = values into the first `size` places of `x`; L has no zero on its diagonal."""
    for j in range(size - 1, -1, -1):
        rest = values[j]
        for later in range(j + 1, size):
            rest -= lower[later, j] * x[later]
        x[j] = rest / lower[j, j]


def scratch(rows: int, n: int) -> FloatArray:
    """Uninitialised (rows, n or more) of whole tiles that start on cache lines: a load across two lines costs twice."""
    width = -(-n // TILE) * TILE
    flat = np.empty(rows * width + 8)
    start = (-flat.ctypes.data % 64) // 8
    return flat[start : start + rows * width].reshape(rows, width)
