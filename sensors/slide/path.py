"""Where the object lies over the sensor while it moves: along a line, or turning in place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.solver import NO_SURFACE
from sensors.slide.shapes import SlidingBody

_DEEPEST_M = 8e-3
"""Parts of an object further below its top than this are never met."""
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Path:
    """Start (m), heading of the object and direction of the motion (rad); `turns`: travel is an angle, not metres."""

    x_m: float
    y_m: float
    heading: float
    direction: float
    turns: bool

    def pose(self, travel: Array | float) -> tuple[Array, Array, Array]:
        """x, y (m) and heading (rad) of the object after `travel`, each of its shape."""
        way = np.asarray(travel, dtype=np.float64)
        along = 0 * way if self.turns else way
        return (
            self.x_m + along * np.cos(self.direction),
            self.y_m + along * np.sin(self.direction),
            self.heading + (way if self.turns else 0 * way),
        )

    def to_object(self, x: Array, y: Array, travel: float) -> tuple[Array, Array]:
        """Points of the sensor's plane in the object's own frame."""
        at_x, at_y, heading = self.pose(travel)
        cos, sin = np.cos(heading), np.sin(heading)
        return cos * (x - at_x) + sin * (y - at_y), -sin * (x - at_x) + cos * (y - at_y)

    def to_sensor(self, points: Array, travel: Array | float) -> Array:
        """Points (n, 2) of the object's frame over the sensor: (..., n, 2) for `travel` (...)."""
        at_x, at_y, heading = (np.asarray(part)[..., None] for part in self.pose(travel))
        cos, sin = np.cos(heading), np.sin(heading)
        x, y = points[:, 0], points[:, 1]
        return np.stack((at_x + cos * x - sin * y, at_y + sin * x + cos * y), axis=-1)


def gap_at(body: SlidingBody, tilt: tuple[float, float], path: Path, travel: float, grid: Grid) -> NDArray[np.float32]:
    """Gap (n, n) in metres between the flat skin and the body at first touch; `tilt` in radians about its own axes."""
    x, y = path.to_object(*grid.coordinates(), travel)
    height = body.height(x, y) + tilt[0] * x + tilt[1] * y
    gap = height.max() - height
    return np.where(gap < _DEEPEST_M, gap, NO_SURFACE).astype(np.float32)
