"""Spectra of fixed size from multi-channel recordings of any length."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from fusion.arrays import FloatArray

Recordings = Sequence[ArrayLike] | NDArray[Any]


class _Spectrum(TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """Shared handling of recordings; a spectrum says what becomes of one z-scored recording.

    Recordings are a list of arrays (T_i, channels), as long as they like, or one array (n, T, channels). A
    matrix (n, T) is n recordings of one channel. Nothing is learnt from the data but their form.
    """

    def fit(self, X: Recordings, y: object = None) -> Self:
        """Note the number of channels (or, for a matrix, its columns); y is ignored."""
        self._check_parameters()
        self.n_channels_ = self._recordings(X, reset=True)[0].shape[1]
        return self

    def transform(self, X: Recordings) -> FloatArray:
        """Spectra of the recordings: (n, bins x channels), bin by bin, the channels of a bin side by side."""
        check_is_fitted(self)
        return np.stack([self._spectrum(z_score(series)).ravel() for series in self._recordings(X, reset=False)])

    @abstractmethod
    def _spectrum(self, series: FloatArray) -> FloatArray:
        """Spectrum (bins, channels) of z-scored `series` (T, channels)."""

    @abstractmethod
    def _check_parameters(self) -> None:
        """ValueError for parameters without meaning."""

    def _recordings(self, X: Recordings, *, reset: bool) -> list[FloatArray]:
        if not _holds_matrices(X):
            matrix = validate_data(self, X, dtype=np.float64, reset=reset)
            return list(matrix[:, :, None])
        series = [np.asarray(x, dtype=np.float64) for x in X]
        channels = series[0].shape[-1] if reset else self.n_channels_
        for i, x in enumerate(series):
            if x.ndim != 2 or x.shape[0] == 0 or x.shape[1] != channels or channels == 0:
                raise ValueError(f"recording {i} must be an array (samples, {channels} channels), got shape {x.shape}.")
            if not np.isfinite(x).all():
                raise ValueError(f"recording {i} holds values that are not finite (NaN or infinity).")
        return series


class FourierBasis(_Spectrum):
    """Least-squares coefficients of sines and cosines, as many for a short recording as for a long one.

    Each channel is z-scored and fitted with 1, sin(w t), cos(w t), ..., sin(m w t), cos(m w t), w = 2 pi / P.
    The output holds, harmonic by harmonic, the sine row and the cosine row of all channels:
    (n, n_harmonics x 2 x channels). The constant is fitted and left out: z-scoring has set it.

    Parameters
    ----------
    n_harmonics : m. Harmonics that a recording of T samples cannot tell apart (2 m + 1 > T) are 0.
    period : P in samples, the same for all recordings; None takes each recording's own length.

    The basis of each length is factorised once (QR, not the normal equations). ValueError where P is so much
    longer than a recording that its harmonics are the same to rounding.

    References
    ----------
    CPM-Finger thesis on fabric texture, section 3.1.2.
    """

    def __init__(self, n_harmonics: int = 25, *, period: float | None = None) -> None:
        self.n_harmonics = n_harmonics
        self.period = period

    def _check_parameters(self) -> None:
        _positive_count("n_harmonics", self.n_harmonics)
        if self.period is not None and not 0 < self.period < np.inf:
            raise ValueError(f"period must be None or a positive number of samples, got {self.period!r}.")

    def _spectrum(self, series: FloatArray) -> FloatArray:
        length = len(series)
        fitted = min(self.n_harmonics, (length - 1) // 2)
        coefficients = np.zeros((2 * self.n_harmonics, series.shape[1]))
        if fitted:
            solve = _fourier_solver(length, fitted, float(length if self.period is None else self.period))
            coefficients[: 2 * fitted] = solve @ series
        return coefficients


class ResampledSpectrum(_Spectrum):
    """Amplitudes of the discrete Fourier transform, resampled to a fixed number of bins.

    Each channel is z-scored; its amplitudes 2 |DFT| / T from zero frequency to half the sampling rate are
    interpolated linearly at `n_bins` equally spaced frequencies: (n, n_bins x channels), bin by bin.

    References
    ----------
    CPM-Finger thesis on fabric texture, section 3.1.1.
    """

    def __init__(self, n_bins: int = 50) -> None:
        self.n_bins = n_bins

    def _check_parameters(self) -> None:
        _positive_count("n_bins", self.n_bins)

    def _spectrum(self, series: FloatArray) -> FloatArray:
        amplitudes = 2.0 * np.abs(np.fft.rfft(series, axis=0)) / len(series)
        at = np.linspace(0.0, 0.5, self.n_bins)
        frequencies = np.fft.rfftfreq(len(series))
        return np.stack([np.interp(at, frequencies, channel) for channel in amplitudes.T], axis=1)


def z_score(series: FloatArray) -> FloatArray:
    """Each channel of `series` (T, channels) to mean 0 and standard deviation 1; a constant one to 0."""
    centred = series - series.mean(axis=0)
    spread = centred.std(axis=0)
    rounding = 10 * np.finfo(np.float64).eps * np.abs(series).max(axis=0)
    return np.asarray(centred / np.where(spread > rounding, spread, np.inf))


@lru_cache(maxsize=1024)
def _fourier_solver(length: int, n_harmonics: int, period: float) -> FloatArray:
    """Matrix (2 m, T) from samples to sine and cosine coefficients by harmonic, the constant's row dropped."""
    angle = 2 * np.pi / period * np.outer(np.arange(length), np.arange(1, n_harmonics + 1))
    waves = np.stack([np.sin(angle), np.cos(angle)], axis=2).reshape(length, -1)
    q, r = np.linalg.qr(np.concatenate([np.ones((length, 1)), waves], axis=1))
    diagonal = np.abs(np.diagonal(r))
    if diagonal.min() <= 1e-10 * diagonal.max():
        raise ValueError(
            f"a recording of {length} samples cannot tell {n_harmonics} harmonics of period {period:g} samples"
            " apart; shorten the period, lower n_harmonics, or leave period=None."
        )
    solver = np.linalg.solve(r, q.T)[1:]
    solver.setflags(write=False)
    return np.asarray(solver)


def _holds_matrices(X: object) -> bool:
    if isinstance(X, np.ndarray):
        return X.ndim == 3
    return isinstance(X, (list, tuple)) and len(X) > 0 and np.ndim(X[0]) == 2


def _positive_count(name: str, value: object) -> None:
    if not isinstance(value, (int, np.integer)) or value < 1:
        raise ValueError(f"{name} must be a whole number of at least 1, got {value!r}.")
