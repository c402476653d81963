"""Triangle meshes made by our own code: every builder is a grid of points, triangulated."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Mesh:
    """Vertices (v, 3) and triangles (t, 3) of vertex numbers; lengths in millimetres, z up."""

    vertices: Array
    faces: NDArray[np.intp]

    def moved(self, offset: ArrayLike = (0.0, 0.0, 0.0), turn: ArrayLike | None = None) -> "Mesh":
        """The mesh turned by a rotation matrix (3, 3) and then shifted by `offset`."""
        turned = self.vertices if turn is None else self.vertices @ np.asarray(turn, float).T
        return Mesh(turned + np.asarray(offset, float), self.faces)


def merge(*meshes: Mesh) -> Mesh:
    """All meshes as one; they may intersect, since only the upper envelope is ever read."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]),
    )


def patch(points: ArrayLike) -> Mesh:
    """Triangulate a grid of points (m, n, 3), two triangles a cell."""
    grid = np.asarray(points, float)
    rows, columns = grid.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return Mesh(grid.reshape(-1, 3), faces)


def lathe(profile: ArrayLike, segments: int = 96) -> Mesh:
    """Turn a profile (k, 2) of (radius, z) about the z axis."""
    radius, z = np.asarray(profile, float).T[:, :, None]
    angle = np.linspace(0.0, 2.0 * np.pi, segments + 1)
    return patch(np.stack(np.broadcast_arrays(radius * np.cos(angle), radius * np.sin(angle), z), -1))


def ellipsoid(centre: ArrayLike, semi_axes: ArrayLike, segments: int = 96) -> Mesh:
    """An ellipsoid with semi-axes along x, y, z; facets lie inside by (pi / segments)**2 / 2 of it."""
    polar = np.linspace(0.0, np.pi, segments // 2 + 1)
    ball = lathe(np.stack([np.sin(polar), np.cos(polar)], -1), segments)
    return Mesh(ball.vertices * np.asarray(semi_axes, float) + np.asarray(centre, float), ball.faces)


def box(lower: ArrayLike, upper: ArrayLike) -> Mesh:
    """The axis-parallel box between two corners."""
    corners = np.stack([np.asarray(lower, float), np.asarray(upper, float)])
    pick = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return Mesh(corners[pick, np.arange(3)], np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def sweep(path: ArrayLike, radius: ArrayLike, segments: int = 32) -> Mesh:
    """A tube of given radius (scalar or one a point) along a path (k, 3) that is nowhere vertical."""
    points = np.asarray(path, float)
    tangent = np.gradient(points, axis=0)
    side = np.cross([0.0, 0.0, 1.0], tangent)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(tangent, side)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    angle = np.linspace(0.0, 2.0 * np.pi, segments + 1)[None, :, None]
    ring = np.cos(angle) * side[:, None] + np.sin(angle) * up[:, None]
    return patch(points[:, None] + np.broadcast_to(radius, len(points))[:, None, None] * ring)


def rotation(axis: str, degrees: float) -> Array:
    """Right-handed rotation matrix (3, 3) about "x", "y" or "z"."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[[i, j], [i, j]] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix
