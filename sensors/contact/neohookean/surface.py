"""Rigid surfaces that press a pad: their gap with slope and curvature, which Newton needs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid

Floats = NDArray[np.float64]

_STEEPEST = 0.95
"""Fraction of the tip radius at which a rounded wall goes on as a straight flank (slope 3, 72 degrees)."""


class SurfaceJet(NamedTuple):
    """Gap (m), its gradient (.., 2) and its second derivative (1/m, .., 2, 2) at some points."""

    gap: Floats
    gradient: Floats
    hessian: Floats


class Surface(Protocol):
    """Gap of a rigid surface above the undeformed pad at first touch, smooth and finite over the whole pad."""

    @property
    def quarter(self) -> bool:
        """Whether x -> -x and y -> -y leave the surface alike, so that a quarter of the pad is enough."""
        ...

    def jet(self, x: Floats, y: Floats) -> SurfaceJet:
        """The gap and its derivatives at points (m) of any one shape."""
        ...


@dataclass(frozen=True)
class SweptSurface:
    """A round edge of `tip_radius_m` swept around a flat core: sphere, cylinder, blunt edge or punch.

    The core is the set of points within `core_radius_m` of a segment of half length `half_length_m` along y. Gap =
    R - sqrt(R^2 - r^2), r the distance from the core; beyond r = 0.95 R a straight flank of slope 3 (72 degrees).
    """

    tip_radius_m: float
    half_length_m: float = 0.0
    core_radius_m: float = 0.0

    def __post_init__(self) -> None:
        if self.tip_radius_m <= 0 or self.half_length_m < 0 or self.core_radius_m < 0:
            raise ValueError(
                "a swept surface needs tip_radius_m > 0, half_length_m >= 0 and core_radius_m >= 0, got "
                f"{self.tip_radius_m}, {self.half_length_m}, {self.core_radius_m}"
            )

    @property
    def quarter(self) -> bool:
        """Always: a segment at the centre has both planes of symmetry."""
        return True

    def jet(self, x: Floats, y: Floats) -> SurfaceJet:
        """See `Surface`."""
        beyond = np.sign(y) * np.maximum(np.abs(y) - self.half_length_m, 0)
        distance = np.hypot(x, beyond)
        height, slope, bend = self._profile(np.maximum(distance - self.core_radius_m, 0))
        safe = np.where(distance > 0, distance, 1.0)
        outward = np.stack([np.where(distance > 0, x / safe, 1.0), beyond / safe], axis=-1)
        along = np.stack([-outward[..., 1], outward[..., 0]], axis=-1)
        # level sets bend only around the ends of the segment; at distance 0 slope / distance -> 1 / R
        hoop = np.where(distance > 0, slope / safe, bend) * (np.abs(y) >= self.half_length_m)
        hessian = bend[..., None, None] * outward[..., :, None] * outward[..., None, :]
        hessian = hessian + hoop[..., None, None] * along[..., :, None] * along[..., None, :]
        return SurfaceJet(height, slope[..., None] * outward, hessian)

    def _profile(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        """Height, slope and curvature of the swept edge at distance `r` from the core."""
        radius, reach = self.tip_radius_m, _STEEPEST * self.tip_radius_m
        inner = np.minimum(r, reach)
        root = np.sqrt(radius**2 - inner**2)
        flank = r > reach
        height = radius - root + inner / root * (r - inner)
        flat = (r == 0) & (self.core_radius_m > 0)
        return height, inner / root, np.where(flank | flat, 0.0, radius**2 / root**3)


class GridSurface:
    """A gap given on the cells of a grid, as a cubic B-spline with the cells as control points.

    It is twice differentiable, never leaves the range of its neighbours and rounds edges by about a cell; a smooth
    surface is off by pitch^2 / 6 times its mean curvature. Cells without a surface (inf) stand at `ceiling_m`.
    """

    def __init__(self, grid: Grid, gap: NDArray[np.floating], ceiling_m: float) -> None:
        if gap.shape != (grid.n, grid.n):
            raise ValueError(f"gap must have the grid's shape ({grid.n}, {grid.n}), got {gap.shape}")
        if np.isnan(gap).any() or not np.isfinite(gap).any():
            raise ValueError("gap must be finite somewhere and hold no NaN")
        self.grid = grid
        self._control = np.pad(np.minimum(np.asarray(gap, float), ceiling_m), 2, mode="edge")
        control = self._control
        close = 1e-9 * float(np.ptp(control))
        self.quarter = bool(
            np.allclose(control, control[::-1], 0, close) and np.allclose(control, control[:, ::-1], 0, close)
        )

    def jet(self, x: Floats, y: Floats) -> SurfaceJet:
        """See `Surface`; outside the grid the outermost cells go on."""
        n, pitch = self.grid.n, self.grid.pitch_m
        column, u = _cell(x / pitch + n / 2 - 0.5, n)
        row, v = _cell(y / pitch + n / 2 - 0.5, n)
        near = np.arange(4)
        patch = self._control[row[..., None, None] + near[:, None], column[..., None, None] + near]
        along_x, along_y = _weights(u, pitch), _weights(v, pitch)

        def mixed(i: int, j: int) -> Floats:
            return np.einsum("...a,...ab,...b->...", along_y[j], patch, along_x[i])

        gradient = np.stack([mixed(1, 0), mixed(0, 1)], axis=-1)
        hessian = np.stack([mixed(2, 0), mixed(1, 1), mixed(1, 1), mixed(0, 2)], axis=-1)
        return SurfaceJet(mixed(0, 0), gradient, hessian.reshape(*x.shape, 2, 2))


def _cell(position: Floats, n: int) -> tuple[NDArray[np.int64], Floats]:
    """First of the four control points (in the padded array) around a position in cells, and the rest in [0, 1]."""
    clipped = np.clip(position, -1.0, float(n))
    whole = np.minimum(np.floor(clipped), n - 1.0)
    return whole.astype(np.int64) + 1, clipped - whole


def _weights(t: Floats, pitch: float) -> tuple[Floats, Floats, Floats]:
    """Cubic B-spline weights (.., 4) at t in [0, 1], with their first and second derivatives per metre."""
    s = 1 - t
    value = np.stack([s**3, 4 - 6 * t**2 + 3 * t**3, 4 - 6 * s**2 + 3 * s**3, t**3], axis=-1) / 6
    slope = np.stack([-(s**2), t * (3 * t - 4), s * (4 - 3 * s), t**2], axis=-1) / (2 * pitch)
    bend = np.stack([s, 3 * t - 2, 3 * s - 2, t], axis=-1) / pitch**2
    return value, slope, bend
