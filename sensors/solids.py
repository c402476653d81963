"""Rigid solids that rays meet: where a ray from outside enters a ball, a box or a half-space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Solid(Protocol):
    """Anything that rays can enter."""

    def entry(self, origins: Array, directions: Array) -> Array:
        """Distances (n,; m) along unit `directions` (n, 3) from `origins` (n, 3); inf for a miss.

        0 or less from inside; a solid that lies behind the origin is a miss.
        """
        ...


@dataclass(frozen=True)
class Ball:
    """Centre (3,; m) and radius (m)."""

    centre: tuple[float, float, float]
    radius: float

    def entry(self, origins: Array, directions: Array) -> Array:
        """See `Solid`."""
        from_centre = origins - np.asarray(self.centre)
        half = np.einsum("ni,ni->n", from_centre, directions)
        inside = half**2 - np.einsum("ni,ni->n", from_centre, from_centre) + self.radius**2
        root = np.sqrt(np.maximum(inside, 0))
        return np.where((inside > 0) & (root - half > 0), -half - root, np.inf)


@dataclass(frozen=True)
class Box:
    """Centre (3,; m), half edges (3,; m) and the rotation (3, 3) whose columns are the box's axes."""

    centre: tuple[float, float, float]
    half: tuple[float, float, float]
    rotation: Array | None = None

    def entry(self, origins: Array, directions: Array) -> Array:
        """See `Solid`: the slab method in the box's own axes."""
        turn = np.eye(3) if self.rotation is None else np.asarray(self.rotation)
        start, along = (origins - np.asarray(self.centre)) @ turn, directions @ turn
        steep = np.where(np.abs(along) > 1e-15, along, 1e-15)
        near, far = (-np.asarray(self.half) - start) / steep, (np.asarray(self.half) - start) / steep
        enters, leaves = np.minimum(near, far).max(axis=1), np.maximum(near, far).min(axis=1)
        return np.where((enters < leaves) & (leaves > 0), enters, np.inf)


@dataclass(frozen=True)
class HalfSpace:
    """Everything below the plane through `point` with outward unit `normal`."""

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    def entry(self, origins: Array, directions: Array) -> Array:
        """See `Solid`."""
        normal = np.asarray(self.normal)
        height, fall = (origins - np.asarray(self.point)) @ normal, -(directions @ normal)
        reached = np.divide(height, fall, out=np.full(len(height), np.inf), where=fall > 1e-15)
        return np.where(height <= 0, height, np.where(fall > 1e-15, reached, np.inf))
