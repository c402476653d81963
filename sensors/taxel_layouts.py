"""Where the contact elements of a taxel pad lie: one at the centre of each taxel, flat, on a ball, on a fingertip.

A layout is a grid of rows x columns; rows run along y, columns along x, the flat pad faces +z. On the curved ones the
pitch is kept along both arcs through the middle; rows converge towards the poles of the ball and the tip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Layout:
    """Points (n, 3; m), outward unit normals (n, 3) and two tangents (n, 2, 3) of rows x columns elements."""

    points: Array
    normals: Array
    tangents: Array
    rows: int
    columns: int

    def __len__(self) -> int:
        return len(self.points)

    def tangential(self, vectors: Array) -> Array:
        """Components (n, 2) of vectors (n, 3) along the tangents."""
        return np.einsum("nij,nj->ni", self.tangents, vectors)


def flat_layout(rows: int, columns: int, pitch_m: float) -> Layout:
    """A plane grid about the origin that faces +z."""
    x, y = _grid(rows, columns, pitch_m)
    zero = np.zeros_like(x)
    return _layout(np.stack((x, y, zero), 1), np.stack((zero, zero, zero + 1), 1), rows, columns)


def spherical_layout(rows: int, columns: int, pitch_m: float, radius_m: float) -> Layout:
    """A cap of a ball of `radius_m` whose top is the origin. ValueError where the grid reaches past a hemisphere."""
    x, y = _grid(rows, columns, pitch_m)
    _within_hemisphere(max(float(np.abs(x).max()), float(np.abs(y).max())), radius_m)
    normals = _ball_normals(x / radius_m, y / radius_m)
    return _layout(radius_m * (normals - (0, 0, 1)), normals, rows, columns)


def fingertip_layout(rows: int, columns: int, pitch_m: float, radius_m: float) -> Layout:
    """A half-cylinder along y (rows below the middle) that ends in a quarter ball (rows above), top at the origin."""
    x, y = _grid(rows, columns, pitch_m)
    _within_hemisphere(max(float(np.abs(x).max()), float(y.max())), radius_m)
    normals = _ball_normals(x / radius_m, np.maximum(y, 0) / radius_m)
    points = radius_m * (normals - (0, 0, 1)) + np.stack((0 * y, np.minimum(y, 0), 0 * y), 1)
    return _layout(points, normals, rows, columns)


def _grid(rows: int, columns: int, pitch_m: float) -> tuple[Array, Array]:
    if rows < 1 or columns < 1 or not pitch_m > 0:
        raise ValueError(f"a layout needs rows, columns >= 1 and pitch > 0, got {rows}, {columns}, {pitch_m}")
    y, x = np.meshgrid(
        (np.arange(rows) - (rows - 1) / 2) * pitch_m, (np.arange(columns) - (columns - 1) / 2) * pitch_m, indexing="ij"
    )
    return x.ravel(), y.ravel()


def _within_hemisphere(reach_m: float, radius_m: float) -> None:
    if not reach_m < np.pi / 2 * radius_m:
        raise ValueError(
            f"the grid reaches {reach_m * 1e3:.1f} mm along the surface, past the rim of a hemisphere of radius "
            f"{radius_m * 1e3:g} mm: raise the radius or take fewer taxels"
        )


def _ball_normals(across: Array, along: Array) -> Array:
    """Unit vectors at the angle `along` towards y, turned by `across` towards x."""
    return np.stack((np.sin(across) * np.cos(along), np.sin(along), np.cos(across) * np.cos(along)), 1)


def _layout(points: Array, normals: Array, rows: int, columns: int) -> Layout:
    # no normal is along y: the grid ends before the rim
    first = np.cross(np.array([0.0, 1.0, 0.0]), normals)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return Layout(points, normals, np.stack((first, np.cross(normals, first)), 1), rows, columns)
