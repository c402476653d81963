"""Plane outlines as signed distances in mm, negative inside: union `minimum`, cut `maximum(a, -b)`."""

from collections.abc import Sequence
from functools import reduce
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = tuple[float, float]


def circle(x: Array, y: Array, radius: float) -> Array:
    """Distance to a circle about the origin."""
    return np.asarray(np.hypot(x, y) - radius)


def box(x: Array, y: Array, length: float, width: float, corner: float = 0.0) -> Array:
    """Distance to a rectangle about the origin with rounded corners."""
    u, v = np.abs(x) - 0.5 * length + corner, np.abs(y) - 0.5 * width + corner
    outside = np.hypot(np.maximum(u, 0.0), np.maximum(v, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(u, v), 0.0) - corner)


def regular(x: Array, y: Array, sides: int, across_flats: float) -> Array:
    """Largest distance to the side lines of a regular polygon (exact inside), one side facing +x."""
    sector = 2.0 * np.pi / sides
    angle = np.arctan2(y, x)
    offset = angle - sector * np.round(angle / sector)
    return np.asarray(np.hypot(x, y) * np.cos(offset) - 0.5 * across_flats)


def segment(x: Array, y: Array, start: Point, end: Point) -> Array:
    """Distance (never negative) to a straight stroke."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    along = np.clip(((x - start[0]) * dx + (y - start[1]) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
    return np.asarray(np.hypot(x - start[0] - along * dx, y - start[1] - along * dy))


def polyline(x: Array, y: Array, points: Sequence[Point]) -> Array:
    """Distance (never negative) to a chain of strokes."""
    strokes = (segment(x, y, start, end) for start, end in pairwise(points))
    return reduce(np.minimum, strokes)


def polygon(x: Array, y: Array, points: Sequence[Point]) -> Array:
    """Distance to a simple closed polygon."""
    closed = [*points, points[0]]
    inside = np.zeros(np.broadcast_shapes(np.shape(x), np.shape(y)), bool)
    for (x0, y0), (x1, y1) in pairwise(closed):
        crosses = (y0 > y) != (y1 > y)
        slope = (x1 - x0) / (y1 - y0) if y1 != y0 else 0.0
        inside ^= crosses & (x < x0 + slope * (y - y0))
    return np.where(inside, -1.0, 1.0) * polyline(x, y, closed)


def star(x: Array, y: Array, points: int, outer: float, inner: float) -> Array:
    """Distance to a star polygon with one tip towards -y."""
    angle = np.pi * np.arange(2 * points) / points - 0.5 * np.pi
    radius = np.where(np.arange(2 * points) % 2 == 0, outer, inner)
    corners = np.stack([radius * np.cos(angle), radius * np.sin(angle)], -1).tolist()
    return polygon(x, y, [(float(a), float(b)) for a, b in corners])
