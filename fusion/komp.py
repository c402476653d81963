"""Kernel orthogonal matching pursuit: sparse codes of many queries over one dictionary of atoms.

Solves min |phi(s) - phi(D) x|^2 with at most k non-zeros, greedily: it is the l0-constrained problem, not the
l1 objective that some papers print above it (`fusion.gram_lasso` solves that one).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fusion.arrays import FloatArray, IntArray, finite_matrix, frozen
from fusion.gram import Gram, stored_gram
from fusion.settings import is_number, whole_number
from fusion.threads import count_threads, map_threads

PivotTol = float | Literal["auto"]

EPS = float(np.finfo(np.float64).eps)
LEAST_CHUNK = 16  # queries: below, a thread costs more than it saves


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
    normalize_atoms : choose the atom by correlation over the atom's norm (True) or by frozen correlation.
        Coefficients are those of the atoms as given in both cases.
    pivot_tol : stop when the chosen atom's squared distance to the span of the earlier ones is at most this
        part of its squared norm; "auto" is 100 j eps for the j-th atom, whatever `n_nonzero_coefs` is. It is also
        refused where it is within the rounding error that ill-conditioned earlier atoms cause in it, so that a
        code holds no more atoms than the rank.
    n_jobs : threads over chunks of queries (-1: all cores); the result does not depend on it.

    Returns
    -------
    indices : (q, k) int64, atoms in order of selection, then -1; k = min(n_nonzero_coefs, n).
    coefs : (q, k) float64, then 0.
    n_selected : (q,) int64.
    energy : (q,) float64, squared norm of the query's projection; the residual is k(s, s) minus this.

    Besides the pivot, a query stops when the best correlation is at most 8 eps of its first one: a query
    that is an atom takes one atom, a zero query none. Ties go to the lowest index. Atoms with G_ii <= 0 are
    never chosen. The codes of k atoms begin those of k + 1.

    Raises
    ------
    ValueError : shapes that do not fit, values that are not finite, n_nonzero_coefs < 1, G so much smaller than K
        that coefficients or energy pass the largest number.

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
        stored_gram([gram]),
        kernel[None],
        n_nonzero_coefs,
        normalize_atoms=normalize_atoms,
        pivot_tol=pivot_tol,
        n_jobs=n_jobs,
    )
    return codes.indices, codes.coefs[0], codes.n_selected, energy[0]


def joint_komp(
    gram: Gram,
    kernels: FloatArray,
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
    `gram` holds the dictionary's M Gram matrices or the recipe for their rows, `kernels` is (M, q, n),
    `weights` M positive numbers, `chunk` the queries that a thread takes at once. Returns the codes and the
    energies (M, q): |projection on the selected atoms|^2.
    """
    from fusion.pursuit import pursue, scratch

    most = whole_number("n_nonzero_coefs", n_nonzero_coefs, 1)
    kernels = frozen(kernels)
    n_modalities, n_queries, n_atoms = kernels.shape
    k = min(most, n_atoms)
    tolerances = pivot_tolerances(pivot_tol, k)
    scales = _selection_scales(gram.diagonals, weights, normalize_atoms)
    indices = np.full((n_queries, k), -1, dtype=np.int64)
    coefs = np.zeros((n_modalities, n_queries, k))
    energy = np.zeros((n_modalities, n_queries))

    def work(start: int) -> None:
        basis = scratch(n_modalities * k, n_atoms).reshape(n_modalities, k, -1)
        working = scratch(2 * n_modalities + 1, n_atoms)
        stop = min(start + size, n_queries)
        pursue(gram, kernels, scales, tolerances, start, stop, basis, working, indices, coefs, energy)

    threads = count_threads(n_jobs)
    shares = 4 * threads if threads > 1 else 1  # each share pays for scratch that the memory has not seen
    size = chunk or max(LEAST_CHUNK, -(-n_queries // shares))
    map_threads(work, range(0, n_queries, size), n_jobs)
    if not (np.isfinite(coefs).all() and np.isfinite(energy).all()):
        raise ValueError("the atoms' kernel values are too small beside the queries': codes overflow; scale them.")
    return SparseCodes(indices, coefs, np.sum(indices >= 0, axis=1)), energy


def pivot_tolerances(pivot_tol: PivotTol, k: int) -> FloatArray:
    """Part of an atom's squared norm that must lie outside the earlier ones, for the first to the k-th atom: (k,).

    "auto" grows with the atoms taken, not with k, so that a larger k never takes fewer.
    """
    if isinstance(pivot_tol, str) and pivot_tol == "auto":
        return np.asarray(100.0 * np.arange(1, k + 1) * EPS, dtype=np.float64)
    if not is_number(pivot_tol) or not 0 <= pivot_tol < 1:
        raise ValueError(f"pivot_tol must be 'auto' or a number in [0, 1), got {pivot_tol!r}.")
    return np.full(k, pivot_tol, dtype=np.float64)


def _selection_scales(diagonals: FloatArray, weights: Sequence[float] | None, normalize_atoms: bool) -> FloatArray:
    """Factor on each atom's correlation, (M, n); 0 bars the atom."""
    usable = diagonals > 0
    scales = np.where(usable, 1.0 / np.sqrt(np.where(usable, diagonals, 1.0)) if normalize_atoms else 1.0, 0.0)
    if weights is None:
        return np.asarray(scales)
    return np.asarray(np.sqrt(np.asarray(weights, dtype=np.float64))[:, None] * scales)
