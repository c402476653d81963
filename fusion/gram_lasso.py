"""The l1 form of kernel sparse coding: coordinate descent on the Gram matrix, all queries in step.

min over x of  sum_m w_m |phi_m(s) - phi_m(D) x_m|^2 / 2  +  penalty lambda_max sum_i (sum_m w_m x_mi^2)^(1/2)

with lambda_max, each query's own, the smallest factor at which its code is empty. One modality is the lasso;
several are the group lasso with one row support. A penalty relative to lambda_max makes the support blind to
the scale of the query's kernel row, so that far queries of a narrow RBF kernel still get a code.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fusion.komp import CHUNK_BYTES, FloatArray, SparseCodes, map_threads


def gram_lasso(
    grams: Sequence[FloatArray],
    kernels: Sequence[FloatArray],
    penalty: float,
    *,
    weights: Sequence[float] | None = None,
    max_sweeps: int = 200,
    tol: float = 1e-4,
    n_jobs: int | None = None,
) -> SparseCodes:
    """Codes of q queries over n atoms, one row support for the M modalities.

    `grams` are M arrays (n, n), `kernels` M arrays (q, n), `weights` M positive numbers. `penalty` lies in
    (0, 1). A query is done when no step of a sweep moves the gradient by more than `tol` lambda_max, or after
    `max_sweeps` sweeps (near copies among the atoms take many). The support is in order of atom index.
    """
    if not 0 < penalty < 1:
        raise ValueError(f"penalty must lie between 0 and 1 (a part of lambda_max), got {penalty!r}.")
    gram = np.stack(grams)
    roots = np.sqrt(np.ones(len(grams)) if weights is None else np.asarray(weights, dtype=np.float64))
    n_queries, n_atoms = kernels[0].shape
    size = max(1, CHUNK_BYTES // (8 * len(grams) * n_atoms))

    def solve(start: int) -> FloatArray:
        target = np.stack([kernel[start : start + size] for kernel in kernels]) * roots[:, None, None]
        return _descend(gram, target, penalty, max_sweeps, tol) / roots[:, None, None]

    pieces = map_threads(solve, range(0, max(n_queries, 1), size), n_jobs)
    return _compress(np.concatenate(pieces, axis=1))


def _descend(gram: FloatArray, target: FloatArray, penalty: float, max_sweeps: int, tol: float) -> FloatArray:
    """Dense codes (M, q, n) for correlations `target` (M, q, n); a query that is done leaves the sweeps."""
    curvature = np.max(np.diagonal(gram, axis1=1, axis2=2), axis=0)
    atoms = np.flatnonzero(curvature > 0)
    codes = np.zeros_like(target)
    largest = np.max(_norms(target[:, :, atoms]), axis=1, initial=0.0)
    active = np.flatnonzero(largest > 0)
    gradient, x, limit = target[:, active], codes[:, active], largest[active]
    for _ in range(max_sweeps):
        moved = np.zeros(len(active))
        wanted = (x != 0).any(axis=0) | (_norms(gradient) > penalty * limit[:, None])
        for i in atoms[wanted[:, atoms].any(axis=0)]:
            rows = np.flatnonzero(wanted[:, i])
            pull = gradient[:, rows, i] + curvature[i] * x[:, rows, i]
            size = _norms(pull)
            shrink = np.maximum(size - penalty * limit[rows], 0.0) / np.where(size > 0, size, 1.0)
            step = shrink * pull / curvature[i] - x[:, rows, i]
            x[:, rows, i] += step
            gradient[:, rows] -= step[:, :, None] * gram[:, None, i, :]
            moved[rows] = np.maximum(moved[rows], curvature[i] * _norms(step))
        done = moved <= tol * limit
        codes[:, active[done]] = x[:, done]
        active, gradient, x, limit = active[~done], gradient[:, ~done], x[:, ~done], limit[~done]
        if not len(active):
            break
    codes[:, active] = x
    return codes


def _norms(values: FloatArray) -> FloatArray:
    """Euclidean norm over the modalities, the first axis; |value| exactly where there is one."""
    if len(values) == 1:
        return np.asarray(np.abs(values[0]))
    total = values[0] ** 2
    for value in values[1:]:
        total += value**2
    return np.asarray(np.sqrt(total), dtype=np.float64)


def _compress(codes: FloatArray) -> SparseCodes:
    """Dense codes (M, q, n) as index and coefficient rows as wide as the fullest query's support."""
    chosen = (codes != 0).any(axis=0)
    n_selected = chosen.sum(axis=1)
    width = max(1, int(n_selected.max(initial=0)))
    order = np.argsort(~chosen, axis=1, kind="stable")[:, :width]
    filled = np.arange(width) < n_selected[:, None]
    coefs = np.where(filled, np.take_along_axis(codes, order[None], axis=2), 0.0)
    return SparseCodes(np.where(filled, order, -1), coefs, n_selected)
