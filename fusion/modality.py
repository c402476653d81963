"""One modality of a sparse-coding dictionary: its columns, its weight, its atoms and their kernel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fusion.arrays import FloatArray, IntArray, frozen
from fusion.gram import LINEAR, Gram, gram_on_demand, stored_gram
from fusion.kernels import (
    check_squares_last,
    cosine_normalize,
    finite_squares,
    inverse_root,
    pair_matrix,
    resolve_gamma,
    squared_norms,
)
from fusion.settings import check_known, is_number

KernelName = str | Callable[[FloatArray, FloatArray], FloatArray]
COMPUTABLE = ("rbf", "linear")  # whose Gram rows can be had from the atoms at any time


@dataclass(frozen=True, eq=False)
class Modality:
    """Atoms of one modality with kernel and normalisation."""

    kernel: KernelName
    gamma: float
    normalize: bool
    atoms: FloatArray  # (d, n) for "rbf" and "linear", else (n, d) as given
    self_values: FloatArray  # (n,), k(atom, atom) before normalisation

    @classmethod
    def fit(cls, atoms: FloatArray, kernel: KernelName, gamma: object, normalize: bool) -> Modality:
        """Keep `atoms` (n, d), or the Gram matrix (n, n) in their place when precomputed."""
        width = resolve_gamma(gamma, atoms) if kernel == "rbf" else LINEAR
        if kernel == "rbf":
            return cls(kernel, width, normalize, frozen(atoms.T), np.ones(len(atoms)))
        if kernel == "linear":
            check_squares_last(atoms)
            return cls(kernel, width, normalize, frozen(atoms.T), squared_norms(atoms))
        if kernel == "precomputed":
            if atoms.shape[0] != atoms.shape[1]:
                raise ValueError(f"Precomputed kernel must be a square matrix at fit, got shape {atoms.shape}.")
            return cls(kernel, width, normalize, atoms, atoms.diagonal().copy())
        return cls(kernel, width, normalize, atoms, own_values(kernel, atoms) if normalize else np.ones(len(atoms)))

    def gram(self) -> FloatArray:
        """Gram matrix of the atoms: (n, n)."""
        if self.kernel == "rbf":
            matrix = pair_matrix(self.atoms.T, self.atoms, squared=True)
            matrix *= -self.gamma
            return np.asarray(np.exp(matrix, out=matrix))
        if self.kernel == "linear":
            matrix = pair_matrix(self.atoms.T, self.atoms, squared=False)
        else:
            matrix = self.atoms if self.kernel == "precomputed" else call_kernel(self.kernel, self.atoms, self.atoms)
        if self.normalize:
            own = matrix if self.kernel == "linear" else None  # in place, but never into what was given
            matrix = cosine_normalize(matrix, self.self_values, self.self_values, out=own)
            np.fill_diagonal(matrix, np.where(self.self_values > 0, 1.0, 0.0))
        return matrix

    def diagonal(self) -> FloatArray:
        """Kernel values of the atoms with themselves, after normalisation: (n,)."""
        return np.where(self.self_values > 0, 1.0, 0.0) if self.normalize else self.self_values


def dictionary(modalities: Sequence[Modality], store: bool) -> Gram:
    """The modalities' Gram matrices, stored, or to be computed row by row ("rbf" and "linear" only)."""
    if store and len(modalities) == 1:
        return stored_gram([modalities[0].gram()])
    if store:
        n = len(modalities[0].self_values)
        stack = np.empty((len(modalities), n, n))
        for modality, place in zip(modalities, stack, strict=True):
            place[:] = modality.gram()
        return stored_gram(stack)
    normalised = [m.normalize and m.kernel == "linear" for m in modalities]
    return gram_on_demand(
        [m.atoms for m in modalities],
        [m.gamma for m in modalities],
        [
            inverse_root(m.self_values) if cosine else np.ones(len(m.self_values))
            for m, cosine in zip(modalities, normalised, strict=True)
        ],
        [m.diagonal() for m in modalities],
    )


def kernel_rows(modalities: Sequence[Modality], queries: Sequence[FloatArray]) -> FloatArray:
    """Kernel values of the queries with the atoms: (M, q, n); `queries` are M arrays (q, d_m).

    RBF rows of a query are multiplied, in all modalities alike, by exp(its smallest exponent): the closest
    atom gets 1, a whole row cannot underflow, and every residual of the query scales by one common factor.
    """
    rows = np.empty((len(modalities), len(queries[0]), len(modalities[0].self_values)))
    for modality, part, out in zip(modalities, queries, rows, strict=True):
        if modality.kernel == "rbf":
            pair_matrix(part, modality.atoms, squared=True, out=out)
            out *= modality.gamma
            continue
        if modality.kernel == "linear":
            own = finite_squares(squared_norms(part))
            kernel = pair_matrix(part, modality.atoms, squared=False)
        elif modality.kernel == "precomputed":
            kernel, own = part, np.ones(len(part))
        else:
            kernel = call_kernel(modality.kernel, part, modality.atoms)
            own = own_values(modality.kernel, part) if modality.normalize else np.ones(len(part))
        out[:] = cosine_normalize(kernel, own, modality.self_values) if modality.normalize else kernel
    if modalities[0].kernel == "rbf":
        shift = finite_squares(rows.min(axis=(0, 2)))[None, :, None]
        np.subtract(shift, rows, out=rows)
        np.exp(rows, out=rows)
    return rows


def call_kernel(kernel: KernelName, X: FloatArray, Y: FloatArray) -> FloatArray:
    """Values (q, n) of a kernel given as a function of the rows X (q, d) and Y (n, d), checked."""
    assert callable(kernel)
    values = np.asarray(kernel(X, Y), dtype=np.float64)
    if values.shape != (len(X), len(Y)):
        raise ValueError(f"the kernel function must return shape {(len(X), len(Y))}, got {values.shape}.")
    if not np.isfinite(values).all():
        raise ValueError("the kernel function returned values that are not finite (NaN or infinity).")
    return values


def own_values(kernel: KernelName, X: FloatArray) -> FloatArray:
    """Kernel value of each row of X (q, d) with itself, one call of the function a row: (q,)."""
    return np.array([call_kernel(kernel, row[None], row[None])[0, 0] for row in X])


def modality_columns(modalities: Mapping[str, Any], n_features: int) -> dict[str, Any]:
    """Checked columns of each modality: a slice, or column numbers (of a mask of truth values, where it is true).

    ValueError, with the modality's name, when its columns are none, reach past the last column or are no columns.
    """
    if not isinstance(modalities, Mapping) or not modalities:
        raise ValueError(
            f"modalities must name at least one group of columns, or be None for all columns; got {modalities!r}."
        )
    checked = {}
    for name, columns in modalities.items():
        numbers = _column_numbers(name, columns, n_features)
        inside = (columns.stop or 0) <= n_features if isinstance(columns, slice) else _inside(numbers, n_features)
        if not inside or not len(numbers):
            raise ValueError(f"modality {name!r}: columns {columns!r} do not fit the {n_features} columns of X.")
        checked[name] = columns if isinstance(columns, slice) else numbers
    return checked


def _column_numbers(name: object, columns: Any, n_features: int) -> IntArray:
    wanted = f"modality {name!r}: columns must be a slice, whole numbers or a mask of length {n_features}, got "
    if isinstance(columns, slice):
        try:
            return np.arange(n_features)[columns]
        except (TypeError, ValueError):
            raise ValueError(f"{wanted}{columns!r}.") from None
    try:
        given = np.asarray(columns)
    except ValueError:  # lists of several lengths
        raise ValueError(f"{wanted}{columns!r}.") from None
    if given.dtype == bool and given.shape == (n_features,):
        return np.flatnonzero(given)
    if given.size and given.dtype.kind not in "iu":
        raise ValueError(f"{wanted}{columns!r}.")
    return given.astype(np.int64).ravel()


def _inside(numbers: IntArray, n_features: int) -> bool:
    return not len(numbers) or bool(numbers.min() >= 0 and numbers.max() < n_features)


def modality_weights(
    weights: Mapping[str, float] | None, names: Sequence[str], fitted: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Weight of each modality, the fitted one (1 without any) unless given.

    ValueError for unknown names or weights that make no sense.
    """
    if weights is not None and not isinstance(weights, Mapping):
        raise ValueError(f"weights must map names of modalities to numbers, got {weights!r}.")
    given = dict(weights or {})
    check_known("weights name", given, names)
    for name, weight in given.items():
        if not is_number(weight) or not 0 <= weight < np.inf:
            raise ValueError(f"weights must be finite, not negative and not all 0; that of {name!r} is {weight!r}.")
    values = {**dict.fromkeys(names, 1.0), **(fitted or {}), **{name: float(each) for name, each in given.items()}}
    if not any(values.values()):
        raise ValueError(f"weights must be finite, not negative and not all 0; got {values}.")
    return values
