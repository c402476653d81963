"""Kernel between force sequences that allows for their pace: global alignment.

A Gaussian of the dynamic-time-warping distance is no kernel (its matrices have negative eigenvalues); the
global alignment kernel sums over all alignments instead of taking the best one, and is positive definite.
"""

from __future__ import annotations

import numpy as np

from fusion.arrays import FloatArray


class GlobalAlignment:
    """Normalised global alignment kernel between rows that hold whole sequences, for `KSC(kernel=...)`.

    Parameters
    ----------
    n_channels : values a sample (taxels); a row holds time steps x channels numbers, sample after sample.
    sigma : width of the Gaussian between two samples, in the unit of the rows times the root of the length.
        Too small a width leaves every sequence alike to itself only: `sigma_gak` of tslearn proposes one.

    Needs the package tslearn (the extra `sequence`). Values of a sequence with itself are 1, so that
    `normalize_kernel=False` loses nothing and saves a call for each query.

    References
    ----------
    Cuturi, "Fast global alignment kernels", ICML 2011.
    """

    def __init__(self, n_channels: int, sigma: float) -> None:
        if n_channels < 1 or not 0 < sigma < np.inf:
            raise ValueError(
                f"GlobalAlignment needs at least one channel and a positive finite sigma, got {n_channels} and {sigma}."
            )
        self.n_channels = n_channels
        self.sigma = sigma

    def __repr__(self) -> str:
        return f"GlobalAlignment({self.n_channels}, sigma={self.sigma})"

    def __call__(self, X: FloatArray, Y: FloatArray) -> FloatArray:
        """Kernel values of rows of X (q, steps x channels) with rows of Y (n, steps x channels): (q, n)."""
        try:
            from tslearn.metrics import cdist_gak
        except ImportError as error:
            raise ImportError(
                "the global alignment kernel needs tslearn, which is not installed; pip install 'vtbench[sequence]'"
            ) from error
        values = np.asarray(cdist_gak(self._sequences(X), self._sequences(Y), sigma=self.sigma), dtype=np.float64)
        if not np.isfinite(values).all():
            raise ValueError(f"sigma {self.sigma} is too small for these sequences: no kernel value is left; raise it.")
        return values

    def _sequences(self, rows: FloatArray) -> FloatArray:
        if rows.ndim != 2 or rows.shape[1] % self.n_channels:
            raise ValueError(f"rows must hold whole samples of {self.n_channels} channels, got shape {rows.shape}.")
        return rows.reshape(len(rows), -1, self.n_channels)
