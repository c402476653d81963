"""The compiled loop of kernel orthogonal matching pursuit: one query after the other, all steps fused.

One partial Cholesky factorisation per query: row j of `basis` holds the inner products of all atoms with the
j-th orthonormal direction, so a step reads one Gram row and j earlier basis rows, block by block, and the
correlations are updated by bounded numbers even where the coefficients are huge (wide kernels). Nothing is
shared between queries, so that no cut of them into chunks or threads can change a bit.
"""

from __future__ import annotations

import math

import numpy as np

from fusion.arrays import FloatArray, IntArray
from fusion.compiled import compiled, unsigned
from fusion.gram import Gram
from fusion.pairs import gram_row

EPS = float(np.finfo(np.float64).eps)
DOUBTFUL_PIVOT = 1e-4  # of the atom's squared norm: from here on rounding in the pivot is estimated
SIGNLESS = 2**63 - 1  # all bits of a float but its sign
BLOCK = 1024  # atoms worked on at once: a few such rows stay in the first-level cache


@compiled
def pursue(
    gram: Gram,
    kernels: FloatArray,
    scales: FloatArray,
    tol: float,
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
    each atom's correlation (0 bars the atom). `basis` (M, k, n) and `working` (2 M + 1, n) are scratch.
    `indices` (q, k) comes filled with -1, `coefs` (M, q, k) and `energy` (M, q) with 0.
    """
    n_modalities, _, n = kernels.shape
    k = indices.shape[1]
    lower = np.zeros((n_modalities, k, k))
    projections = np.empty((n_modalities, k))
    smallest = np.empty(n_modalities)
    correlations, free, score = working[:n_modalities], working[n_modalities : 2 * n_modalities], working[-1, :n]
    unit = n_modalities == 1
    for m in range(n_modalities):
        for p in range(n):
            free[m, p] = scales[m, p]
            unit = unit and scales[m, p] == 1.0
    if unit:  # sizes are correlations, read where they lie
        score = correlations[0, :n]
    bits = score.view(np.int64)
    for query in range(start, stop):
        for m in range(n_modalities):
            smallest[m] = 1.0
            for p in range(unsigned(0), unsigned(n)):
                correlations[m, p] = kernels[m, query, p]
        first = 0.0
        chosen = indices[query]
        taken = 0
        for step in range(k):
            atom = _best_atom(correlations, free, score, bits, unit)
            best = abs(score[atom])
            if step == 0:
                first = best
            if not (best > 8.0 * EPS * first and best > 0.0):
                break
            independent = False
            for m in range(n_modalities):
                factors = lower[m, step]
                diagonal = pivot = gram.diagonals[m, atom]
                for earlier in range(step):
                    factors[earlier] = basis[m, earlier, atom]
                    pivot -= factors[earlier] * factors[earlier]
                usable = diagonal > 0.0 and pivot > tol * diagonal
                if usable:
                    smallest[m] = min(smallest[m], pivot / diagonal)
                    if smallest[m] < DOUBTFUL_PIVOT:
                        usable = pivot > _pivot_noise(lower[m], gram.diagonals[m], chosen, atom, step)
                independent = independent or usable
                root = math.sqrt(pivot) if usable else 1.0
                projection = correlations[m, atom] / root if usable else 0.0
                factors[step] = root
                projections[m, step] = projection
                energy[m, query] += projection * projection
                if step + 1 < k:
                    _advance(gram, basis, lower, correlations, m, atom, step, usable, projection)
            if not independent:
                break
            chosen[step] = atom
            taken += 1
            for m in range(n_modalities):
                free[m, atom] = 0.0
            if unit:
                for place in range(taken):
                    score[chosen[place]] = 0.0
        for m in range(n_modalities):
            for place in range(taken):
                free[m, chosen[place]] = scales[m, chosen[place]]
            _back_substitute(lower[m], projections[m], taken, coefs[m, query])


@compiled
def _best_atom(correlations: FloatArray, free: FloatArray, scores: FloatArray, bits: IntArray, unit: bool) -> int:
    """Write each atom's size of correlation over the modalities into `scores`; the lowest index of the largest.

    With `unit` the scores are there already, but for their sign. `bits` are the scores read as whole numbers,
    whose order is the same without the sign: that vectorises, and so does a search without an early end.
    """
    n_modalities, n = len(correlations), len(scores)
    largest = np.int64(-1)
    start = stop = unsigned(0)
    for block in range(0, n, BLOCK):
        begin, end = unsigned(block), unsigned(min(block + BLOCK, n))
        if not unit:
            for p in range(begin, end):
                scores[p] = abs(correlations[0, p]) * free[0, p]
        if n_modalities > 1:
            for p in range(begin, end):
                scores[p] *= scores[p]
            for m in range(1, n_modalities):
                for p in range(begin, end):
                    size = correlations[m, p] * free[m, p]
                    scores[p] += size * size
            for p in range(begin, end):
                scores[p] = math.sqrt(scores[p])
        here = np.int64(-1)
        for p in range(begin, end):
            here = max(here, bits[p] & SIGNLESS)
        if here > largest:
            largest, start, stop = here, begin, end
    place = stop
    for p in range(start, stop):
        place = min(place, p if bits[p] & SIGNLESS == largest else stop)
    return int(place)


@compiled
def _advance(
    gram: Gram,
    basis: FloatArray,
    lower: FloatArray,
    correlations: FloatArray,
    m: int,
    atom: int,
    step: int,
    usable: bool,
    projection: float,
) -> None:
    """Write basis row `step`, the part of the Gram row outside the earlier rows, and take it off the query."""
    n = gram.diagonals.shape[1]
    stored = len(gram.stored) > 0
    if not stored:
        gram_row(gram, m, atom, basis[m, step, :n])
    inverse = 1.0 / lower[m, step, step] if usable else 0.0
    whole = 4 * (step // 4)
    for block in range(0, n, BLOCK):
        begin, end = unsigned(block), unsigned(min(block + BLOCK, n))
        if stored:
            for p in range(begin, end):
                basis[m, step, p] = gram.stored[m, atom, p]
        for j in range(0, whole, 4):
            f, g, h, i = lower[m, step, j], lower[m, step, j + 1], lower[m, step, j + 2], lower[m, step, j + 3]
            for p in range(begin, end):
                basis[m, step, p] = (
                    basis[m, step, p]
                    - f * basis[m, j, p]
                    - g * basis[m, j + 1, p]
                    - h * basis[m, j + 2, p]
                    - i * basis[m, j + 3, p]
                )
        for j in range(whole, step):
            f = lower[m, step, j]
            for p in range(begin, end):
                basis[m, step, p] -= f * basis[m, j, p]
        for p in range(begin, end):
            value = basis[m, step, p] * inverse
            basis[m, step, p] = value
            correlations[m, p] -= projection * value


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
    """Uninitialised (rows, n or more) whose rows start on cache lines: a load across two lines costs twice."""
    width = -(-n // 8) * 8
    flat = np.empty(rows * width + 8)
    start = (-flat.ctypes.data % 64) // 8
    return flat[start : start + rows * width].reshape(rows, width)
