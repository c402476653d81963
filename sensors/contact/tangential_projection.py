"""Nearest tractions inside the friction discs |q| <= mu p, with or without a given sum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating]

_STEPS = 60
_CLOSE = 1e-13


def onto_discs(traction: Floats, limit: Floats) -> Floats:
    """The point of each cell's disc nearest to `traction` (2, ...); `limit` (...) >= 0 holds the radii."""
    size = np.hypot(traction[0], traction[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(size > limit, limit / size, 1)
    out: Floats = traction * scale.astype(traction.dtype)
    return out


def onto_discs_with_sum(
    traction: Floats, limit: Floats, total: NDArray[np.float64], guess: NDArray[np.float64]
) -> tuple[Floats, NDArray[np.float64]]:
    """The nearest point of the discs whose sum over cells is `total` (2,), |total| below the sum of the radii.

    It is the projection of `traction` + m for one m (2,), which is returned with it: m minimises a smooth convex
    function, whose slope is the sum less `total`; damped Newton from `guess`, in double precision.
    """
    pressed = limit > 0
    points, radii = traction[:, pressed].astype(np.float64), limit[pressed].astype(np.float64)
    scale = float(radii.sum())
    m = guess
    if scale > 0:
        value, slope, bend = _dual(points + m[:, None], radii, total, m)
        for _ in range(_STEPS):
            if np.abs(slope).max() <= _CLOSE * scale:
                break
            # a little of the largest curvature keeps the step finite where every cell slips the same way
            step = np.linalg.solve(bend + 1e-9 * len(radii) * np.eye(2), -slope)
            for _ in range(_STEPS):
                trial = _dual(points + (m + step)[:, None], radii, total, m + step)
                if trial[0] <= value + 1e-4 * float(slope @ step) + 1e-14 * abs(value):
                    break
                step = step / 2
            m = m + step
            value, slope, bend = trial
    shifted = traction + m.reshape(2, *[1] * limit.ndim)
    return onto_discs(shifted.astype(traction.dtype), limit), m


def _dual(
    z: NDArray[np.float64], radii: NDArray[np.float64], total: NDArray[np.float64], m: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """sum (|z|^2 - max(|z| - radius, 0)^2) / 2 - total.m, its slope and its second derivative by m."""
    size = np.hypot(z[0], z[1])
    outside = size > radii
    safe = np.where(size > 0, size, 1.0)
    scale = np.where(outside, radii / safe, 1.0)
    value = 0.5 * float((size**2 - np.maximum(size - radii, 0) ** 2).sum()) - float(total @ m)
    slope = (z * scale).sum(axis=1) - total
    unit = np.where(outside, z / safe, 0.0)
    bend = scale.sum() * np.eye(2) - (unit * scale) @ unit.T
    return value, slope, bend
