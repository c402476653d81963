"""PCA by modality: every group of columns reduced and scaled on its own, then put side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from fusion.arrays import FloatArray
from fusion.modality import modality_columns

WHOLE = "all"
DOUBTFUL = 1e-4  # of the largest singular value: below, squares have lost too many digits


class ModalityPCA(TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """Standardise each group of columns, reduce it by PCA, scale it to mean squared norm 1, weigh it, join all.

    Parameters
    ----------
    groups : name -> columns of X (a slice or an array of column numbers); None is one group "all". Columns in
        no group are left out.
    n_components : components per group, at most what the group's columns and the samples allow: one number for
        every group, or name -> number. None, or a group not named, keeps the standardised columns.
    weights : name -> factor on the scaled group; 1 where not named, 0 blanks a group.

    Attributes
    ----------
    output_groups_ : name -> slice of the output's columns, as `JKSC(modalities=...)` takes it.
    n_features_in_ : columns of X.

    Everything is learnt from `fit` data alone. A constant column stays 0, a constant group is all 0.
    """

    def __init__(
        self,
        groups: Mapping[str, Any] | None = None,
        n_components: Mapping[str, int | None] | int | None = None,
        weights: Mapping[str, float] | None = None,
    ) -> None:
        self.groups = groups
        self.n_components = n_components
        self.weights = weights

    def fit(self, X: ArrayLike, y: object = None) -> Self:
        """Learn means, scales and components from X (n, d); y is ignored."""
        data = validate_data(self, X, dtype=np.float64)
        groups = {WHOLE: slice(0, data.shape[1])} if self.groups is None else self.groups
        self._columns = modality_columns(groups, data.shape[1])
        weights = self._named(self.weights, "weights")
        components = self._named(
            self.n_components
            if self.n_components is None or isinstance(self.n_components, Mapping)
            else dict.fromkeys(self._columns, self.n_components),
            "n_components",
        )
        self._parts: dict[str, _Part] = {}
        self.output_groups_: dict[str, slice] = {}
        start = 0
        for name, columns in self._columns.items():
            part = _Part(data[:, columns], components.get(name), float(weights.get(name, 1.0)), name)
            self._parts[name] = part
            self.output_groups_[name] = slice(start, start + part.width)
            start += part.width
        return self

    def transform(self, X: ArrayLike) -> FloatArray:
        """Reduced groups of X (n, d) side by side: (n, sum of the groups' widths), float64."""
        check_is_fitted(self)
        data = validate_data(self, X, dtype=np.float64, reset=False)
        return np.concatenate(
            [self._parts[name].apply(data[:, columns]) for name, columns in self._columns.items()], axis=1
        )

    def get_feature_names_out(self, input_features: ArrayLike | None = None) -> NDArray[np.object_]:
        """Names of the output's columns: the group and the place in it, as "image0"."""
        check_is_fitted(self)
        names = [f"{name}{i}" for name, part in self._parts.items() for i in range(part.width)]
        return np.array(names, dtype=object)

    def _named(self, values: Mapping[str, Any] | None, what: str) -> dict[str, Any]:
        given = dict(values or {})
        unknown = sorted(set(given) - set(self._columns))
        if unknown:
            raise ValueError(f"{what} name {', '.join(unknown)}; the groups are {', '.join(self._columns)}.")
        return given


class _Part:
    """What is learnt about one group of columns."""

    def __init__(self, data: FloatArray, n_components: int | None, weight: float, name: str) -> None:
        if n_components is not None and (not isinstance(n_components, (int, np.integer)) or n_components < 1):
            raise ValueError(f"n_components of group {name!r} must be None or at least 1, got {n_components!r}.")
        if not np.isfinite(weight) or weight < 0:
            raise ValueError(f"weight of group {name!r} must be finite and not negative, got {weight!r}.")
        self.mean = data.mean(axis=0)
        spread = data.std(axis=0)
        rounding = 10 * np.finfo(np.float64).eps * np.abs(data).max(axis=0)
        self.spread = np.where(spread > rounding, spread, np.inf)
        standard = (data - self.mean) / self.spread
        self.axes: FloatArray | None = None
        if n_components is not None:
            count = min(int(n_components), *data.shape)
            self.axes = _principal_axes(standard, count) if standard.any() else np.eye(count, data.shape[1])
        reduced = self._reduce(standard)
        energy = float(np.mean(np.sum(reduced**2, axis=1)))
        self.scale = weight / np.sqrt(energy) if energy > 0 else weight
        self.width = reduced.shape[1]

    def apply(self, data: FloatArray) -> FloatArray:
        return self._reduce((data - self.mean) / self.spread) * self.scale

    def _reduce(self, standard: FloatArray) -> FloatArray:
        return standard if self.axes is None else standard @ self.axes.T


def _principal_axes(standard: FloatArray, count: int) -> FloatArray:
    """First `count` principal axes of rows (n, d), in order, their largest entries positive: (count, d).

    From the eigenvectors of the smaller of the two squared matrices, a quarter of the work of decomposing the
    rows but blind to singular values below 1e-8 of the largest, and from them one step with the rows themselves.
    Where an axis to be kept has a singular value below `DOUBTFUL`, the rows are decomposed after all.
    """
    from scipy.linalg import eigh

    standard = standard - standard.mean(axis=0)  # the mean of large numbers is known to their rounding alone
    n, d = standard.shape
    square = standard.T @ standard if d < n else standard @ standard.T
    size = len(square)
    values, vectors = eigh(square, subset_by_index=[size - count, size - 1], overwrite_a=True, check_finite=False)
    if values[0] <= DOUBTFUL**2 * values[-1]:
        axes = np.linalg.svd(standard, full_matrices=False)[2][:count]
    else:
        inside = np.linalg.qr(standard.T @ (standard @ vectors if d < n else vectors))[0]
        axes = np.linalg.svd(standard @ inside, full_matrices=False)[2] @ inside.T
    largest = axes[np.arange(count), np.argmax(np.abs(axes), axis=1)]
    return np.asarray(axes * np.sign(largest)[:, None])
