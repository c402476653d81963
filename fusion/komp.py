"""Kernel orthogonal matching pursuit: sparse codes of many queries over one dictionary of atoms.

Solves min |phi(s) - phi(D) x|^2 with at most k non-zeros, greedily: it is the l0-constrained problem, not the
l1 objective that some papers print above it (`fusion.gram_lasso` solves that one).

One partial Cholesky factorisation per query: row j of `basis` holds the inner products of all atoms with the
j-th orthonormal direction, so a step costs one gathered Gram row and j + 1 axpys, and the correlations are
updated by bounded numbers even where the coefficients are huge (wide kernels). All arithmetic is element-wise
over queries: cutting the queries into other chunks, or threads, cannot change a bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Literal, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
PivotTol = float | Literal["auto"]

T = TypeVar("T")
R = TypeVar("R")

EPS = float(np.finfo(np.float64).eps)
DOUBTFUL_PIVOT = 1e-4  # of the atom's squared norm: from here on rounding in the pivot is estimated
CHUNK_BYTES = 2**22  # of basis rows per chunk: what stays in a core's cache


class SparseCodes(NamedTuple):
    """Codes of q queries in M modalities over one support; unused places hold index -1, coefficient 0."""

    indices: IntArray  # (q, k), in order of selection
    coefs: FloatArray  # (M, q, k)
    n_selected: IntArray  # (q,)


def kernel_omp_gram(
    G: ArrayLike,
    K: ArrayLike,
    n_nonzero_coefs: int,
    *,
    normalize_atoms: bool = True,
    pivot_tol: PivotTol = "auto",
    n_jobs: int | None = None,
) -> tuple[IntArray, FloatArray, IntArray, FloatArray]:
    """Sparse codes of all queries by kernel orthogonal matching pursuit.

    Parameters
    ----------
    G : (n, n) kernel values between the atoms; computed in float64 whatever comes in.
    K : (q, n) kernel values between the queries and the atoms.
    n_nonzero_coefs : most atoms in one code; more than n means n.
    normalize_atoms : choose the atom by correlation over the atom's norm (True) or by plain correlation.
        Coefficients are those of the atoms as given in both cases.
    pivot_tol : stop when the chosen atom's squared distance to the span of the earlier ones is at most this
        part of its squared norm; "auto" is 100 k eps. It is also refused where it is within the rounding error
        that ill-conditioned earlier atoms cause in it, so that a code holds no more atoms than the rank.
    n_jobs : threads over chunks of queries (-1: all cores); the result does not depend on it.

    Returns
    -------
    indices : (q, k) int64, atoms in order of selection, then -1; k = min(n_nonzero_coefs, n).
    coefs : (q, k) float64, then 0.
    n_selected : (q,) int64.
    energy : (q,) float64, squared norm of the query's projection; the residual is k(s, s) minus this.

    Besides the pivot, a query stops when the best correlation is at most 8 eps of its first one: a query
    that is an atom takes one atom, a zero query none. Ties go to the lowest index. Atoms with G_ii <= 0 are
    never chosen.

    Raises
    ------
    ValueError : shapes that do not fit, values that are not finite, n_nonzero_coefs < 1.

    References
    ----------
    Li, Gao, Sun, "Kernel sparse representation based classification", Neurocomputing, 2011.
    Nguyen, Patel, Nasrabadi, Chellappa, "Design of non-linear kernel dictionaries", IEEE TIP, 2013.
    Rubinstein, Zibulevsky, Elad, "Efficient implementation of the K-SVD algorithm using batch OMP", 2008.
    """
    gram = finite_matrix(G, "G")
    kernel = finite_matrix(K, "K")
    if gram.shape[0] != gram.shape[1]:
        raise ValueError(f"G must be square (atoms x atoms), got shape {gram.shape}.")
    if kernel.shape[1] != gram.shape[0]:
        raise ValueError(f"K must have one column per atom, ({gram.shape[0]}), got shape {kernel.shape}.")
    codes, energy = joint_komp(
        [gram],
        [kernel],
        n_nonzero_coefs,
        normalize_atoms=normalize_atoms,
        pivot_tol=pivot_tol,
        n_jobs=n_jobs,
    )
    return codes.indices, codes.coefs[0], codes.n_selected, energy[0]


def joint_komp(
    grams: Sequence[FloatArray],
    kernels: Sequence[FloatArray],
    n_nonzero_coefs: int,
    *,
    weights: Sequence[float] | None = None,
    normalize_atoms: bool = True,
    pivot_tol: PivotTol = "auto",
    n_jobs: int | None = None,
    chunk: int | None = None,
) -> tuple[SparseCodes, FloatArray]:
    """Simultaneous pursuit: M modalities choose one support per query, each fits its own coefficients.

    The atom chosen has the largest root of the weighted sum over modalities of squared normalised
    correlations (Tropp, Gilbert, Strauss 2006; Liu, Guo, Sun 2016). An atom that is dependent on the earlier
    ones in one modality gets coefficient 0 there; one that is dependent in all of them ends the code.
    `grams` are M arrays (n, n), `kernels` M arrays (q, n), `weights` M positive numbers, `chunk` the queries
    worked on at once. Returns the codes and the energies (M, q): |projection on the selected atoms|^2.
    """
    if not isinstance(n_nonzero_coefs, (int, np.integer)) or n_nonzero_coefs < 1:
        raise ValueError(f"n_nonzero_coefs must be a whole number of at least 1, got {n_nonzero_coefs!r}.")
    n_queries, n_atoms = kernels[0].shape
    k = min(int(n_nonzero_coefs), n_atoms)
    tol = 100.0 * k * EPS if pivot_tol == "auto" else float(pivot_tol)
    if not 0 <= tol < 1:
        raise ValueError(f"pivot_tol must be 'auto' or a number in [0, 1), got {pivot_tol!r}.")
    roots = np.sqrt(np.ones(len(grams)) if weights is None else np.asarray(weights, dtype=np.float64))
    scales = [root * _selection_scale(gram, normalize_atoms) for gram, root in zip(grams, roots, strict=True)]

    size = chunk or max(1, CHUNK_BYTES // (8 * len(grams) * k * n_atoms))
    pieces = map_threads(
        lambda start: _pursue(grams, [kernel[start : start + size] for kernel in kernels], scales, k, tol),
        range(0, max(n_queries, 1), size),
        n_jobs,
    )
    codes = SparseCodes(
        np.concatenate([piece.indices for piece, _ in pieces]),
        np.concatenate([piece.coefs for piece, _ in pieces], axis=1),
        np.concatenate([piece.n_selected for piece, _ in pieces]),
    )
    return codes, np.concatenate([energy for _, energy in pieces], axis=1)


def _pursue(
    grams: Sequence[FloatArray],
    kernels: Sequence[FloatArray],
    scales: Sequence[FloatArray],
    k: int,
    tol: float,
) -> tuple[SparseCodes, FloatArray]:
    """Codes and energies of one chunk of queries, step by step together."""
    n_modalities, (q, n) = len(grams), kernels[0].shape
    rows = np.arange(q)
    correlations = [kernel.copy() for kernel in kernels]
    free_scales = [np.repeat(scale[None, :], q, axis=0) for scale in scales]
    diagonals = [gram.diagonal() for gram in grams]
    basis = np.empty((n_modalities, k, q, n))
    lower = np.zeros((n_modalities, q, k, k))
    projections = np.zeros((n_modalities, q, k))
    indices = np.full((q, k), -1, dtype=np.int64)
    first = np.zeros(q)
    alive = np.ones(q, dtype=bool)
    smallest = np.ones((n_modalities, q))
    energy = np.zeros((n_modalities, q))
    product = np.empty((q, n))

    for step in range(k):
        score = _scores(correlations, free_scales)
        atom = np.argmax(score, axis=1)
        best = score[rows, atom]
        if step == 0:
            first = best
        alive &= (best > 8.0 * EPS * first) & (best > 0)
        independent = np.zeros(q, dtype=bool)
        for m in range(n_modalities):
            row = basis[m, step]
            np.take(grams[m], atom, axis=0, out=row, mode="clip")
            for earlier in range(step):
                factor = basis[m, earlier][rows, atom]
                lower[m, :, step, earlier] = factor
                np.multiply(factor[:, None], basis[m, earlier], out=product)
                row -= product
            pivot = row[rows, atom]
            diagonal = diagonals[m][atom]
            usable = alive & (diagonal > 0) & (pivot > tol * diagonal)
            smallest[m] = np.minimum(smallest[m], np.where(usable, pivot / np.where(usable, diagonal, 1), 1))
            doubtful = np.flatnonzero(usable & (smallest[m] < DOUBTFUL_PIVOT))
            if len(doubtful):
                noise = _pivot_noise(lower[m, doubtful], indices[doubtful, :step], diagonals[m], diagonal[doubtful])
                usable[doubtful] = pivot[doubtful] > noise
            root = np.sqrt(np.where(usable, pivot, 1.0))
            row *= np.where(usable, 1.0 / root, 0.0)[:, None]
            lower[m, :, step, step] = root
            projection = np.where(usable, correlations[m][rows, atom] / root, 0.0)
            projections[m, :, step] = projection
            energy[m] += projection**2
            np.multiply(projection[:, None], row, out=product)
            correlations[m] -= product
            free_scales[m][rows, atom] = 0.0
            independent |= usable
        alive &= independent
        if not alive.any():
            break
        indices[:, step] = np.where(alive, atom, -1)

    coefs = np.stack([_back_substitute(lower[m], projections[m]) for m in range(n_modalities)])
    return SparseCodes(indices, coefs, np.sum(indices >= 0, axis=1)), energy


def _pivot_noise(lower: FloatArray, chosen: IntArray, diagonals: FloatArray, own: FloatArray) -> FloatArray:
    """Rounding error to expect in the next pivot of each query: (q,).

    With w the chosen atoms' coefficients that best rebuild the next atom, errors of eps in the Gram matrix
    reach the pivot as eps (|d_i| + sum_a |w_a| |d_a|)^2. `lower` is (q, k, k) with the next atom's row filled
    in up to its diagonal, `chosen` (q, step), `diagonals` (n,), `own` (q,) the next atom's squared norm.
    """
    step = chosen.shape[1]
    w = _back_substitute(lower[:, :step, :step], lower[:, step, :step])
    size = np.sqrt(own)
    for place in range(step):
        size = size + np.abs(w[:, place]) * np.sqrt(np.maximum(diagonals[chosen[:, place]], 0.0))
    return np.asarray(8.0 * EPS * size**2)


def _scores(correlations: Sequence[FloatArray], scales: Sequence[FloatArray]) -> FloatArray:
    """Size of the correlation of each query with each atom over all modalities: (q, n)."""
    sizes = [np.abs(correlation) * scale for correlation, scale in zip(correlations, scales, strict=True)]
    if len(sizes) == 1:
        return sizes[0]
    total = sizes[0] ** 2
    for size in sizes[1:]:
        total += size**2
    return np.asarray(np.sqrt(total))


def _selection_scale(gram: FloatArray, normalize_atoms: bool) -> FloatArray:
    """Factor on each atom's correlation, (n,); 0 bars the atom."""
    diagonal = gram.diagonal()
    usable = diagonal > 0
    scale = 1.0 / np.sqrt(np.where(usable, diagonal, 1.0)) if normalize_atoms else 1.0
    return np.where(usable, scale, 0.0)


def _back_substitute(lower: FloatArray, projections: FloatArray) -> FloatArray:
    """Coefficients x of L' x = y for each query: `lower` (q, k, k), `projections` (q, k)."""
    k = projections.shape[1]
    coefs = np.zeros_like(projections)
    for j in range(k - 1, -1, -1):
        rest = projections[:, j].copy()
        for later in range(j + 1, k):
            rest -= lower[:, later, j] * coefs[:, later]
        pivot = lower[:, j, j]
        coefs[:, j] = np.divide(rest, pivot, out=np.zeros_like(rest), where=pivot > 0)
    return coefs


def finite_matrix(values: ArrayLike, name: str) -> FloatArray:
    """`values` as a contiguous float64 matrix; ValueError when it is empty, no matrix, or not finite."""
    matrix = np.ascontiguousarray(values, dtype=np.float64)
    if matrix.ndim != 2 or matrix.shape[1] == 0:
        raise ValueError(f"{name} must be a matrix with at least one column, got shape {matrix.shape}.")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name} holds values that are not finite (NaN or infinity); remove or fill them first.")
    return matrix


def map_threads(function: Callable[[T], R], items: Iterable[T], n_jobs: int | None) -> list[R]:
    """[function(item) for item in items], over `n_jobs` threads (None: 1, negative: as in joblib)."""
    threads = 1
    if n_jobs is not None:
        from joblib import effective_n_jobs

        threads = effective_n_jobs(n_jobs)
    if threads == 1:
        return [function(item) for item in items]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, items))
