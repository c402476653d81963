"""The l1 form of kernel sparse coding: coordinate descent on the Gram matrix.

min over x of  sum_m w_m |phi_m(s) - phi_m(D) x_m|^2 / 2  +  penalty lambda_max sum_i (sum_m w_m x_mi^2)^(1/2)

with lambda_max, each query's own, the smallest factor at which its code is empty. One modality is the lasso;
several are the group lasso with one row support. A penalty relative to lambda_max makes the support blind to
the scale of the query's kernel row, so that far queries of a narrow RBF kernel still get a code.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fusion.arrays import FloatArray, frozen
from fusion.compiled import compiled, unsigned
from fusion.gram import Gram, stored_gram
from fusion.komp import SparseCodes
from fusion.settings import is_number
from fusion.threads import map_threads

CHUNK_BYTES = 2**22  # of dense codes that a thread takes at once


def gram_lasso(
    grams: Gram | Sequence[FloatArray],
    kernels: FloatArray | Sequence[FloatArray],
    penalty: float,
    *,
    weights: Sequence[float] | None = None,
    max_sweeps: int = 200,
    tol: float = 1e-4,
    n_jobs: int | None = None,
) -> SparseCodes:
    """Codes of q queries over n atoms, one row support for the M modalities.

    `grams` are M arrays (n, n), or a `Gram` that stores them, `kernels` M arrays (q, n), `weights` M positive
    numbers. `penalty` lies in (0, 1). A query is done when no step of a sweep moves the gradient by more than
    `tol` lambda_max, or after `max_sweeps` sweeps (near copies among the atoms take many). The support is
    in order of atom index.
    """
    check_penalty(penalty)
    gram = grams if isinstance(grams, Gram) else stored_gram(grams)
    kernels = frozen(kernels)
    n_modalities, n_queries, n_atoms = kernels.shape
    roots = np.sqrt(np.ones(n_modalities) if weights is None else np.asarray(weights, dtype=np.float64))
    curvature = gram.diagonals.max(axis=0)
    codes = np.zeros(kernels.shape)

    def solve(start: int) -> None:
        stop = min(start + size, n_queries)
        _descend(gram.stored, curvature, kernels, roots, penalty, max_sweeps, tol, start, stop, codes)

    size = max(1, CHUNK_BYTES // (8 * n_modalities * n_atoms))
    map_threads(solve, range(0, n_queries, size), n_jobs)
    return _compress(codes)


def check_penalty(penalty: object) -> None:
    """ValueError unless `penalty` is a number between 0 and 1."""
    if not is_number(penalty) or not 0 < penalty < 1:  # type: ignore[operator]
        raise ValueError(f"penalty must lie between 0 and 1 (a part of lambda_max), got {penalty!r}.")


@compiled
def _descend(
    grams: FloatArray,
    curvature: FloatArray,
    kernels: FloatArray,
    roots: FloatArray,
    penalty: float,
    max_sweeps: int,
    tol: float,
    start: int,
    stop: int,
    codes: FloatArray,
) -> None:
    """Write the dense codes of the queries from `start` to `stop` into `codes` (M, q, n), which is 0."""
    n_modalities, _, n = kernels.shape
    gradient = np.empty((n_modalities, n))
    wanted = np.empty(n, dtype=np.bool_)
    pull = np.empty(n_modalities)
    for query in range(start, stop):
        limit = 0.0
        for i in range(n):
            for m in range(n_modalities):
                gradient[m, i] = kernels[m, query, i] * roots[m]
            if curvature[i] > 0.0:
                limit = max(limit, _norm(gradient[:, i]))
        if limit == 0.0:
            continue
        threshold = penalty * limit
        for _ in range(max_sweeps):
            moved = 0.0
            for i in range(n):
                taken = False
                for m in range(n_modalities):
                    taken = taken or codes[m, query, i] != 0.0
                wanted[i] = curvature[i] > 0.0 and (taken or _norm(gradient[:, i]) > threshold)
            for i in range(n):
                if not wanted[i]:
                    continue
                for m in range(n_modalities):
                    pull[m] = gradient[m, i] + curvature[i] * codes[m, query, i]
                length = _norm(pull)
                shrink = max(length - threshold, 0.0) / (length if length > 0.0 else 1.0)
                for m in range(n_modalities):
                    change = shrink * pull[m] / curvature[i] - codes[m, query, i]
                    pull[m] = change
                    codes[m, query, i] += change
                    if change != 0.0:
                        for p in range(unsigned(0), unsigned(n)):
                            gradient[m, p] -= change * grams[m, i, p]
                moved = max(moved, curvature[i] * _norm(pull))
            if moved <= tol * limit:
                break
        for m in range(n_modalities):
            for i in range(n):
                codes[m, query, i] /= roots[m]


@compiled
def _norm(values: FloatArray) -> float:
    """Euclidean norm over the modalities; |value| exactly where there is one."""
    if len(values) == 1:
        return abs(values[0])
    total = 0.0
    for value in values:
        total += value * value
    return math.sqrt(total)


def _compress(codes: FloatArray) -> SparseCodes:
    """Dense codes (M, q, n) as index and coefficient rows as wide as the fullest query's support."""
    chosen = (codes != 0).any(axis=0)
    n_selected = chosen.sum(axis=1)
    width = max(1, int(n_selected.max(initial=0)))
    order = np.argsort(~chosen, axis=1, kind="stable")[:, :width]
    filled = np.arange(width) < n_selected[:, None]
    coefs = np.where(filled, np.take_along_axis(codes, order[None], axis=2), 0.0)
    return SparseCodes(np.where(filled, order, -1), coefs, n_selected)
