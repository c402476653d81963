"""Solids as heights above the table in millimetres: 0 where absent, so union is `numpy.maximum`."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Knots = Sequence[tuple[float, float]]


def extrude(distance: Array, height: float | Array, edge: float = 0.0) -> Array:
    """A plate with the outline `distance` < 0, its upper edge rounded with radius `edge`."""
    inside = distance < 0.0
    if edge <= 0.0:
        return np.asarray(np.where(inside, height, 0.0))
    lean = np.clip(1.0 + distance / edge, 0.0, 1.0)
    drop = edge * (1.0 - np.sqrt(1.0 - lean**2))
    return np.asarray(np.where(inside, height - drop, 0.0))


def follow(position: Array, knots: Knots) -> Array:
    """The piecewise linear curve through (position, value) knots, constant beyond its ends."""
    at, value = zip(*knots, strict=True)
    return np.asarray(np.interp(position, at, value))


def turned(x: Array, y: Array, knots: Knots, axis_height: float, relief: Array | float = 0.0) -> Array:
    """A lathe-turned body lying along x: knots are (x, radius), its axis at `axis_height`.

    `relief` is added to the radius; outside the knots there is nothing.
    """
    radius = follow(x, knots) + relief
    present = (x > knots[0][0]) & (x < knots[-1][0]) & (np.abs(y) < radius)
    return np.where(present, axis_height + np.sqrt(np.maximum(radius**2 - y**2, 0.0)), 0.0)


def upright(x: Array, y: Array, knots: Knots) -> Array:
    """A lathe-turned body standing on the table: knots are (radius, height), nothing beyond the last."""
    radius = np.hypot(x, y)
    return np.where(radius < knots[-1][0], follow(radius, knots), 0.0)


def ellipsoid(x: Array, y: Array, semi_axes: tuple[float, float, float], middle: float) -> Array:
    """The upper half of an ellipsoid about the origin, its middle at height `middle`."""
    rest = 1.0 - (x / semi_axes[0]) ** 2 - (y / semi_axes[1]) ** 2
    return np.where(rest > 0.0, middle + semi_axes[2] * np.sqrt(np.maximum(rest, 0.0)), 0.0)


def rod(distance: Array, radius: float | Array, axis_height: float | Array) -> Array:
    """A round rod along any plane curve, given the distance to the curve."""
    rest = np.asarray(radius) ** 2 - distance**2
    return np.where(rest > 0.0, axis_height + np.sqrt(np.maximum(rest, 0.0)), 0.0)


def lying_hexagon(y: Array, across_flats: float) -> Array:
    """Cross-section of a hexagonal bar lying on a flat side, without its end faces."""
    corner = across_flats / np.sqrt(3.0)
    v = np.abs(y)
    top = np.minimum(across_flats, 0.5 * across_flats + np.sqrt(3.0) * (corner - v))
    return np.where(v < corner, top, 0.0)


def bump(distance: Array, height: float, slope: float = 0.15) -> Array:
    """Marks: `height` where `distance` < 0, let down smoothly over `slope` on both sides of the edge."""
    t = np.clip(0.5 - 0.5 * distance / slope, 0.0, 1.0)
    return height * t * t * (3.0 - 2.0 * t)
