"""Nearest neighbours weighted by exp(-distance), with an answer for samples of no known class."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from fusion.arrays import FloatArray
from fusion.kernels import finite_squares, squared_distances
from fusion.nearest import smallest
from fusion.settings import not_negative, whole_number

BLOCK_BYTES = 2**25  # of distances per block of queries


class WeightedKNN(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """Classify by the sum of exp(-d) over the nearest neighbours of each class, d the Euclidean distance.

    Parameters
    ----------
    n_neighbors : neighbours that vote; all samples where there are fewer.
    novelty_threshold : W; a sample is of a new class when the sum of every known class is below W. None: never.
    novel_label : what `predict` answers for a new class; "auto" is -1 where the labels are numbers (one below
        the smallest where that is taken) and "unknown" where they are strings. It must not be a known label.

    Attributes
    ----------
    classes_ : (n_classes,) known labels in order (never the novel label).
    n_features_in_ : columns of X.

    Equal distances go to the sample seen first, equal sums to the first class. exp(-d) makes the unit of X
    matter: scale the features so that typical distances within a class are about 1.

    References
    ----------
    CPM-Finger thesis on fabric texture, eq. 3.16 to 3.18. Dudani, "The distance-weighted k-nearest-neighbor
    rule", IEEE Trans. SMC, 1976.
    """

    def __init__(
        self,
        n_neighbors: int = 10,
        *,
        novelty_threshold: float | None = None,
        novel_label: Any = "auto",
    ) -> None:
        self.n_neighbors = n_neighbors
        self.novelty_threshold = novelty_threshold
        self.novel_label = novel_label

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Keep the rows of X (n, d) with the labels y (n,)."""
        data, labels = validate_data(self, X, y, dtype=np.float64)
        return self._keep(data, labels, [])

    def partial_fit(self, X: ArrayLike, y: ArrayLike, classes: ArrayLike | None = None) -> Self:
        """Add rows; a label not seen before opens a new class. `classes` may announce labels; it need not."""
        announced = [] if classes is None else [np.asarray(classes)]
        if not hasattr(self, "_samples"):
            data, labels = validate_data(self, X, y, dtype=np.float64)
            return self._keep(data, labels, announced)
        data, labels = validate_data(self, X, y, dtype=np.float64, reset=False)
        return self._keep(
            np.concatenate([self._samples, data]),
            np.concatenate([self._labels, labels]),
            [self.classes_, *announced],
        )

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Label of each row of X (q, d), or the novel label."""
        sums, nearest = self._class_sums(X)
        labels = self.classes_[np.argmax(sums, axis=1)]
        novel = self._below_threshold(sums, nearest)
        if self.novelty_threshold is not None:
            labels = _wide_enough(labels, self._novel_label)
        return np.where(novel, self._novel_label, labels) if novel.any() else np.asarray(labels)

    def predict_proba(self, X: ArrayLike) -> FloatArray:
        """Part of each known class in the sum of weights: (q, n_classes); the threshold plays no part."""
        sums, _ = self._class_sums(X)
        return np.asarray(sums / sums.sum(axis=1, keepdims=True))

    def is_novel(self, X: ArrayLike) -> NDArray[np.bool_]:
        """Whether every known class sums below the threshold: (q,); all False without a threshold."""
        return self._below_threshold(*self._class_sums(X))

    def _keep(self, data: FloatArray, labels: NDArray[Any], known: list[NDArray[Any]]) -> Self:
        if labels.dtype.kind not in "biu":  # whole numbers are classes; finding that out costs as much as the fit
            check_classification_targets(labels)
        whole_number("n_neighbors", self.n_neighbors, 1)
        threshold = self.novelty_threshold
        if threshold is not None:
            not_negative("novelty_threshold, where it is not None,", threshold)
        classes = np.unique(np.concatenate([labels, *known]))
        novel_label = self._choose_novel_label(classes)
        if threshold is not None and novel_label in classes:
            raise ValueError(f"novel_label {novel_label!r} is one of the classes; choose another one.")
        self.classes_, self._novel_label = classes, novel_label
        self._samples, self._labels = data, labels
        self._sample_class = np.searchsorted(classes, labels)
        return self

    def _choose_novel_label(self, classes: NDArray[Any]) -> Any:
        if not isinstance(self.novel_label, str) or self.novel_label != "auto":
            return self.novel_label
        if classes.dtype.kind in "biu":  # as a Python number: it may not fit the labels' type
            return min(-1, int(classes.min()) - 1)
        return "unknown" if classes.dtype.kind in "OUS" else min(-1, classes.min() - 1)

    def _class_sums(self, X: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Sums of exp(nearest - d) per class (q, n_classes) and the nearest distance (q,).

        Divided by exp(-nearest) the sums cannot all underflow, and their order stays the same.
        """
        check_is_fitted(self)
        data = validate_data(self, X, dtype=np.float64, reset=False)
        block = max(1, BLOCK_BYTES // (8 * len(self._samples)))
        parts = [self._block_sums(data[start : start + block]) for start in range(0, len(data), block)]
        return np.concatenate([sums for sums, _ in parts]), np.concatenate([near for _, near in parts])

    def _block_sums(self, data: FloatArray) -> tuple[FloatArray, FloatArray]:
        distances = np.sqrt(squared_distances(data, self._samples))
        order = smallest(distances, self.n_neighbors)
        near = np.take_along_axis(distances, order, axis=1)
        finite_squares(near[:, 0])
        weights = np.exp(near[:, :1] - near)
        sums = np.zeros((len(data), len(self.classes_)))
        rows = np.arange(len(data))
        for place in range(order.shape[1]):
            sums[rows, self._sample_class[order[:, place]]] += weights[:, place]
        return sums, near[:, 0]

    def _below_threshold(self, sums: FloatArray, nearest: FloatArray) -> NDArray[np.bool_]:
        if self.novelty_threshold is None:
            return np.zeros(len(sums), dtype=bool)
        return np.asarray(sums.max(axis=1) * np.exp(-nearest) < self.novelty_threshold)


def _wide_enough(labels: NDArray[Any], novel: Any) -> NDArray[Any]:
    """Whole-number labels in their own type where a whole-number `novel` fits it, else in int64, else as objects."""
    if labels.dtype.kind not in "iu" or not isinstance(novel, (int, np.integer)):
        return labels
    for kind in (labels.dtype, np.dtype(np.int64)):
        info = np.iinfo(kind)
        if info.min <= int(novel) <= info.max and (kind == labels.dtype or np.can_cast(labels.dtype, kind)):
            return labels.astype(kind, copy=False)
    return labels.astype(object)
