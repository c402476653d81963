"""The three bodies that slide: heights in closed form, metres, own dimensions (the paper names none)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Height = Callable[[Array, Array], Array]

_OUTSIDE = -np.inf


@dataclass(frozen=True)
class SlidingBody:
    """A rigid body: `height(x, y)` in metres over its own plane, -inf beside it, z up towards the skin.

    `crown_contrast` is how much the load on one thread crown varies (standard deviation, relative) as the body's
    roughness rides over the weave: smooth plastic 0.15, planed wood 0.20, turned metal 0.12. Assumptions, fixed before
    any detector was scored.
    """

    name: str
    title: str
    height: Height
    crown_contrast: float


def _sphere(radius: float) -> Height:
    def height(x: Array, y: Array) -> Array:
        square = radius**2 - x**2 - y**2
        return np.where(square > 0, np.sqrt(np.maximum(square, 0)), _OUTSIDE)

    return height


def _block(length: float, width: float, edge_radius: float) -> Height:
    """A flat top whose edges and corners are rounded."""

    def height(x: Array, y: Array) -> Array:
        over_x = np.maximum(np.abs(x) - (length / 2 - edge_radius), 0)
        over_y = np.maximum(np.abs(y) - (width / 2 - edge_radius), 0)
        square = edge_radius**2 - over_x**2 - over_y**2
        return np.where(square > 0, np.sqrt(np.maximum(square, 0)), _OUTSIDE)

    return height


def _lying_cylinder(length: float, radius: float, end_radius: float) -> Height:
    """Axis along y, rims rounded: a torus quarter at each end."""

    def height(x: Array, y: Array) -> Array:
        over = np.maximum(np.abs(y) - (length / 2 - end_radius), 0)
        rim = radius - end_radius + np.sqrt(np.maximum(end_radius**2 - over**2, 0))
        square = rim**2 - x**2
        there = (over < end_radius) & (square > 0)
        return np.where(there, np.sqrt(np.maximum(square, 0)), _OUTSIDE)

    return height


BODIES: dict[str, SlidingBody] = {
    body.name: body
    for body in (
        SlidingBody("ball", "ball, 40 mm across", _sphere(20e-3), 0.15),
        SlidingBody("cuboid", "cuboid, 20 x 30 mm, edges rounded to 2 mm", _block(20e-3, 30e-3, 2e-3), 0.20),
        SlidingBody("cylinder", "lying cylinder, 30 mm across, 45 mm long", _lying_cylinder(45e-3, 15e-3, 3e-3), 0.12),
    )
}


def body(name: str) -> SlidingBody:
    """The body of that name. Raises ValueError with the names there are."""
    if name not in BODIES:
        raise ValueError(f"unknown sliding body {name!r}: expected one of {', '.join(BODIES)}")
    return BODIES[name]
