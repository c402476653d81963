"""How close a rendered frame is to the real one: L1, SSIM and PSNR of the same pixels."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

_WINDOW, _SIGMA = 11, 1.5
_PEAK = 255.0


@dataclass(frozen=True)
class ImageScores:
    """`l1` in grey levels of 0..255 (lower is better), `ssim` up to 1, `psnr_db` in decibels (inf when equal)."""

    l1: float
    ssim: float
    psnr_db: float


def image_scores(real: NDArray[np.uint8], rendered: NDArray[np.uint8]) -> ImageScores:
    """Compare two uint8 frames of one shape (rows, columns, channels); ValueError for other input."""
    if real.shape != rendered.shape or real.ndim != 3 or min(real.shape[:2]) < _WINDOW:
        raise ValueError(
            f"expected two frames of one shape (rows, columns, channels), at least {_WINDOW} pixels a side, "
            f"got {real.shape} and {rendered.shape}"
        )
    if real.dtype != np.uint8 or rendered.dtype != np.uint8:
        raise ValueError(f"expected uint8 frames (grey levels 0..255), got {real.dtype} and {rendered.dtype}")
    a, b = real.astype(np.float64), rendered.astype(np.float64)
    squared = float(((a - b) ** 2).mean())
    psnr = float(10 * np.log10(_PEAK**2 / squared)) if squared > 0 else float("inf")
    return ImageScores(float(np.abs(a - b).mean()), structural_similarity(a, b), psnr)


def structural_similarity(a: NDArray[np.number], b: NDArray[np.number]) -> float:
    """Mean SSIM over windows that lie inside the frame and over channels, for grey levels 0..255.

    Gaussian windows of 11x11, sigma 1.5, K1 = 0.01, K2 = 0.03, population moments: Z. Wang, A. C. Bovik, H. R. Sheikh,
    E. P. Simoncelli, IEEE Trans. Image Processing 13(4), 2004.
    """
    c1, c2 = (0.01 * _PEAK) ** 2, (0.03 * _PEAK) ** 2
    a, b = a.astype(np.float64), b.astype(np.float64)
    mean_a, mean_b = _windowed(a), _windowed(b)
    variance_a = _windowed(a * a) - mean_a**2
    variance_b = _windowed(b * b) - mean_b**2
    covariance = _windowed(a * b) - mean_a * mean_b
    luminance = (2 * mean_a * mean_b + c1) / (mean_a**2 + mean_b**2 + c1)
    structure = (2 * covariance + c2) / (variance_a + variance_b + c2)
    return float((luminance * structure).mean())


def _windowed(field: NDArray[np.number]) -> NDArray[np.float64]:
    inside = slice(_WINDOW // 2, -(_WINDOW // 2))
    means: NDArray[np.float64] = cv2.GaussianBlur(field, (_WINDOW, _WINDOW), _SIGMA)[inside, inside]
    return means
