"""One modality of a sparse-coding dictionary: its columns, its weight, its atoms and their Gram matrix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fusion.kernels import (
    FloatArray,
    cosine_normalize,
    linear_kernel,
    rbf_kernel,
    resolve_gamma,
    squared_distances,
    squared_norms,
)


@dataclass(frozen=True, eq=False)
class Modality:
    """Atoms (n, d) of one modality with kernel, normalisation and Gram matrix (n, n)."""

    kernel: str
    gamma: float
    normalize: bool
    atoms: FloatArray
    self_values: FloatArray  # (n,), k(atom, atom) before normalisation
    gram: FloatArray

    @classmethod
    def fit(cls, atoms: FloatArray, kernel: str, gamma: object, normalize: bool) -> Modality:
        """Compute the Gram matrix of `atoms` (n, d), or take `atoms` (n, n) for it when precomputed."""
        width = resolve_gamma(gamma, atoms) if kernel == "rbf" else 1.0
        if kernel == "rbf":
            return cls(kernel, width, normalize, atoms, np.ones(len(atoms)), rbf_kernel(atoms, atoms, width))
        if kernel == "precomputed" and atoms.shape[0] != atoms.shape[1]:
            raise ValueError(f"Precomputed kernel must be a square matrix at fit, got shape {atoms.shape}.")
        gram = linear_kernel(atoms, atoms) if kernel == "linear" else atoms
        own = gram.diagonal().copy()
        if normalize:
            gram = cosine_normalize(gram, own, own)
            np.fill_diagonal(gram, np.where(own > 0, 1.0, 0.0))
        return cls(kernel, width, normalize, atoms, own, gram)


def kernel_rows(modalities: Sequence[Modality], queries: Sequence[FloatArray]) -> list[FloatArray]:
    """Kernel values of the queries with the atoms, one (q, n) array per modality; `queries` are (q, d_m).

    RBF rows of a query are multiplied, in all modalities alike, by exp(its smallest exponent): the closest
    atom gets 1, a whole row cannot underflow, and every residual of the query scales by one common factor.
    """
    if modalities[0].kernel == "rbf":
        exponents = [m.gamma * squared_distances(q, m.atoms) for m, q in zip(modalities, queries, strict=True)]
        shift = np.min([e.min(axis=1) for e in exponents], axis=0)[:, None]
        return [np.exp(shift - e) for e in exponents]
    rows = []
    for modality, part in zip(modalities, queries, strict=True):
        kernel = linear_kernel(part, modality.atoms) if modality.kernel == "linear" else part
        if modality.normalize:
            own = squared_norms(part) if modality.kernel == "linear" else np.ones(len(part))
            kernel = cosine_normalize(kernel, own, modality.self_values)
        rows.append(kernel)
    return rows


def modality_columns(modalities: Mapping[str, Any], n_features: int) -> dict[str, Any]:
    """Checked columns of each modality; ValueError when one is empty or reaches past the last column."""
    if not modalities:
        raise ValueError("modalities must name at least one group of columns, or be None for all columns.")
    checked = {}
    for name, columns in modalities.items():
        if isinstance(columns, slice):
            inside = (columns.stop or 0) <= n_features
            numbers = np.arange(n_features)[columns]
        else:
            numbers = np.asarray(columns, dtype=np.int64).ravel()
            inside = not len(numbers) or bool((numbers.min() >= 0) and (numbers.max() < n_features))
        if not inside or not len(numbers):
            raise ValueError(f"modality {name!r}: columns {columns!r} do not fit the {n_features} columns of X.")
        checked[name] = columns if isinstance(columns, slice) else numbers
    return checked


def modality_weights(weights: Mapping[str, float] | None, names: Sequence[str]) -> dict[str, float]:
    """Weight of each modality, 1 unless given; ValueError for unknown names or weights that make no sense."""
    given = dict(weights or {})
    unknown = sorted(set(given) - set(names))
    if unknown:
        raise ValueError(f"weights name {', '.join(unknown)}; the modalities are {', '.join(names)}.")
    values = {name: float(given.get(name, 1.0)) for name in names}
    if not all(np.isfinite(v) and v >= 0 for v in values.values()) or not any(values.values()):
        raise ValueError(f"weights must be finite, not negative and not all 0; got {values}.")
    return values
