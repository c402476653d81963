"""Error ellipsoids: one class of samples as a centre, orthogonal axes and radii."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fusion.arrays import FloatArray, finite_matrix

FLAT = 1e-12  # of the largest variance: below it a direction holds rounding only


@dataclass(frozen=True, eq=False)
class ErrorEllipsoid:
    """The set {x : (x - centre)' C^-1 (x - centre) <= k^2} of a class, with C its covariance.

    A class of fewer points than dimensions + 1, or of points on a plane, gives a flat ellipsoid: its radius
    is 0 across that plane, and it holds only points of that plane.
    """

    centre: FloatArray  # (d,)
    axes: FloatArray  # (d, d), unit vectors in rows, longest radius first
    radii: FloatArray  # (d,), k times the standard deviation along each axis
    k: float
    confidence: float
    n_points: int

    @property
    def rank(self) -> int:
        """Number of radii above 0."""
        return int(np.sum(self.radii > 0))

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each of `points` (n, d) lies in the ellipsoid or on its surface, to rounding: (n,)."""
        data = finite_matrix(points, "points")
        if data.shape[1] != len(self.centre):
            raise ValueError(f"points must have {len(self.centre)} columns, got {data.shape[1]}.")
        offset = (data - self.centre) @ self.axes.T
        rank = self.rank
        inside = np.sum((offset[:, :rank] / self.radii[:rank]) ** 2, axis=1) <= 1 + 1e-9
        across = np.abs(offset[:, rank:]).max(axis=1, initial=0.0)
        size = max(float(self.radii.max()), float(np.abs(self.centre).max()))
        return np.asarray(inside & (across <= 1e-9 * size))


def error_ellipsoids(X: ArrayLike, y: ArrayLike, *, confidence: float = 0.95) -> dict[Hashable, ErrorEllipsoid]:
    """Error ellipsoid of each class, by eigendecomposition of its covariance.

    X is (n, d), y (n,) labels; the result maps each label, in order, to its ellipsoid. k is the root of the
    chi-squared quantile of `confidence` with d degrees of freedom, so that a normal class lies inside with
    that probability. The covariance divides by n - 1; a class of one point has radii 0.

    Raises
    ------
    ValueError : X not a finite matrix, y of another length, confidence outside (0, 1).

    References
    ----------
    CPM-Finger thesis on fabric texture, section 3.4 (k as in its Table 3.1, where the 99 % entry in three
    dimensions, 3.358, is a misprint of 3.368; its eq. 3.26 writes the inverse of the eigenvalues).
    """
    data = finite_matrix(X, "X")
    labels = np.asarray(y)
    if labels.shape != (len(data),):
        raise ValueError(f"y must hold one label per row of X, ({len(data)},), got shape {labels.shape}.")
    k = ellipsoid_scale(confidence, data.shape[1])
    return {label.item(): _ellipsoid(data[labels == label], k, confidence) for label in np.unique(labels)}


def ellipsoid_scale(confidence: float, n_dimensions: int) -> float:
    """k with P(x' C^-1 x < k^2) = confidence for a normal x of `n_dimensions`."""
    from scipy.stats import chi2

    if not 0 < confidence < 1:
        raise ValueError(f"confidence must lie between 0 and 1, got {confidence!r}.")
    return float(np.sqrt(chi2.ppf(confidence, n_dimensions)))


def _ellipsoid(points: FloatArray, k: float, confidence: float) -> ErrorEllipsoid:
    centre = points.mean(axis=0)
    offset = points - centre
    variances, vectors = np.linalg.eigh(offset.T @ offset / max(1, len(points) - 1))
    variances, axes = variances[::-1], vectors.T[::-1]
    noise = max(FLAT * variances[0], (16 * np.finfo(np.float64).eps * np.abs(points).max()) ** 2)
    most = min(len(points) - 1, points.shape[1])
    solid = (variances > noise) & (np.arange(points.shape[1]) < most)
    radii = k * np.sqrt(np.where(solid, variances, 0.0))
    return ErrorEllipsoid(centre, axes.copy(), radii, k, confidence, len(points))
