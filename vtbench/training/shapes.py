"""Procedural shapes to press for training: none is one of the household objects that tasks ask about.

Shape numbers 2k and 2k + 1 are twins, the second a little stretched and with another pitch of relief, so that telling
shapes apart needs their detail. A number gives the same shape everywhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.objects.forms import extrude, rod
from sensors.objects.outlines import polyline
from sensors.objects.textures import noise, ridges

Array = NDArray[np.float64]
Surface = Callable[[Array, Array], Array]
"""Height in millimetres above the table at points (x, y) in millimetres."""

_ENTROPY = 0x5A4150
_TWIN = (1.14, 0.92)
"""Stretch of a twin along x and y."""
_TWIN_PITCH = 1.4


@dataclass(frozen=True)
class Shape:
    """One training shape: a body, a relief on it, and how it is stretched."""

    number: int
    body: Surface
    relief: Surface
    stretch: tuple[float, float]

    def height(self, x: Array, y: Array) -> Array:
        """Height (mm) above the table at points (x, y) in mm; 0 where there is nothing."""
        u, v = x / self.stretch[0], y / self.stretch[1]
        body = self.body(u, v)
        return np.where(body > 0, np.maximum(body + self.relief(u, v), 0.3), 0.0)

    def placed(self, grid_n: int, size_m: float, pose: tuple[float, float, float]) -> NDArray[np.float32]:
        """Height (grid_n, grid_n) in metres over a sensor of side `size_m`; `pose` is (x mm, y mm, degrees).

        A cell is the mean of 2 x 2 points.
        """
        axis = ((np.arange(2 * grid_n) + 0.5) / (2 * grid_n) - 0.5) * size_m * 1e3
        x, y = np.meshgrid(axis - pose[0], axis - pose[1])
        cosine, sine = np.cos(np.deg2rad(pose[2])), np.sin(np.deg2rad(pose[2]))
        fine = self.height(cosine * x + sine * y, cosine * y - sine * x)
        return (1e-3 * fine.reshape(grid_n, 2, grid_n, 2).mean(axis=(1, 3))).astype(np.float32)


def shape(number: int) -> Shape:
    """The shape of that number; ValueError below zero."""
    if number < 0:
        raise ValueError(f"a shape number must be >= 0, got {number}")
    pair, twin = divmod(number, 2)
    rng = np.random.default_rng([_ENTROPY, pair])
    bodies = (_dome, _plate, _strokes, _dots, _ring)
    body = bodies[pair % len(bodies)](rng)
    if rng.random() < 0.3:
        body = _both(body, _dome(rng, small=True), rng.uniform(-12, 12, 2))
    reliefs = (_plain, _grating, _rough, _rough, _stipple)
    relief = reliefs[int(rng.integers(len(reliefs)))](rng, _TWIN_PITCH if twin else 1.0)
    return Shape(number, body, relief, _TWIN if twin else (1.0, 1.0))


def _dome(rng: np.random.Generator, small: bool = False) -> Surface:
    """A superellipsoid: round to boxy outline, peaked to flat top."""
    a, b = rng.uniform(3, 8, 2) if small else rng.uniform(5, 26, 2)
    outline, top, height = rng.uniform(1.2, 6), rng.uniform(1.2, 6), rng.uniform(4, 14)

    def surface(x: Array, y: Array) -> Array:
        rest = 1 - np.abs(x / a) ** outline - np.abs(y / b) ** outline
        return np.asarray(height * np.maximum(rest, 0) ** (1 / top))

    return surface


def _plate(rng: np.random.Generator) -> Surface:
    """A plate with a wavy outline and a rounded edge."""
    radius, height, edge = rng.uniform(6, 22), rng.uniform(4, 10), rng.uniform(0.3, 4)
    orders = rng.integers(2, 8, 3)
    depth, phase = rng.uniform(0, 0.18, 3), rng.uniform(0, 2 * np.pi, 3)
    squeeze = rng.uniform(0.35, 1)

    def surface(x: Array, y: Array) -> Array:
        angle = np.arctan2(y / squeeze, x)
        rim = radius * (1 + sum(d * np.cos(k * angle + p) for k, d, p in zip(orders, depth, phase, strict=True)))
        return extrude((np.hypot(x, y / squeeze) - rim) * squeeze, height, edge)

    return surface


def _strokes(rng: np.random.Generator) -> Surface:
    """Bent rods, as of hand-written letters."""
    parts = []
    for _ in range(int(rng.integers(1, 4))):
        start = rng.uniform(-14, 14, 2)
        turns = np.cumsum(rng.normal(0, 0.9, int(rng.integers(2, 5)))) + rng.uniform(0, 2 * np.pi)
        steps = rng.uniform(6, 16, len(turns))[:, None] * np.stack([np.cos(turns), np.sin(turns)], 1)
        points = np.vstack([start, start + np.cumsum(steps, 0)])
        points *= 25 / max(25.0, float(np.abs(points).max()))
        parts.append((rng.uniform(1.2, 4.5), [(float(u), float(v)) for u, v in points]))

    def surface(x: Array, y: Array) -> Array:
        rods = [rod(polyline(x, y, points), radius, 5.0) for radius, points in parts]
        return np.asarray(np.maximum.reduce(rods))

    return surface


def _dots(rng: np.random.Generator) -> Surface:
    """Balls of several sizes, their tops at nearly the same height."""
    count = int(rng.integers(3, 12))
    places, radii = rng.uniform(-20, 20, (count, 2)), rng.uniform(2, 7, count)
    sunk = rng.uniform(0, 1.0, count)

    def surface(x: Array, y: Array) -> Array:
        balls = [rod(np.hypot(x - u, y - v), r, 10.0 - r - s) for (u, v), r, s in zip(places, radii, sunk, strict=True)]
        return np.asarray(np.maximum.reduce(balls))

    return surface


def _ring(rng: np.random.Generator) -> Surface:
    """A rod bent to a superellipse: a ring, a frame."""
    a, b = rng.uniform(6, 22, 2)
    power, radius = rng.uniform(1.5, 6), rng.uniform(1.5, 5)

    def surface(x: Array, y: Array) -> Array:
        level = (np.abs(x / a) ** power + np.abs(y / b) ** power) ** (1 / power)
        return rod((level - 1) * min(a, b), radius, 5.0)

    return surface


def _both(first: Surface, second: Surface, offset: Array) -> Surface:
    return lambda x, y: np.maximum(first(x, y), second(x - offset[0], y - offset[1]))


def _plain(rng: np.random.Generator, pitch: float) -> Surface:
    return lambda x, y: np.zeros(np.shape(x))


def _grating(rng: np.random.Generator, pitch: float) -> Surface:
    """Ridges in one direction, perhaps crossed."""
    angle, period, height = rng.uniform(0, np.pi), pitch * rng.uniform(2.5, 9), rng.uniform(0.3, 2)
    crossed = rng.random() < 0.4

    def relief(x: Array, y: Array) -> Array:
        along = ridges(x * np.cos(angle) + y * np.sin(angle), period, height)
        return along * ridges(y * np.cos(angle) - x * np.sin(angle), period, 1.0) if crossed else along

    return relief


def _rough(rng: np.random.Generator, pitch: float) -> Surface:
    """Smooth noise of one grain."""
    grain, height, seed = pitch * rng.uniform(1.5, 9), rng.uniform(0.2, 1.5), int(rng.integers(2**31))
    return lambda x, y: height * noise(x, y, grain, seed)


def _stipple(rng: np.random.Generator, pitch: float) -> Surface:
    """A hexagonal field of small bumps."""
    period, height = pitch * rng.uniform(3, 8), rng.uniform(0.4, 1.6)

    def relief(x: Array, y: Array) -> Array:
        waves = [np.cos(2 * np.pi * (x * np.cos(t) + y * np.sin(t)) / period) for t in np.pi * np.arange(3) / 3]
        return np.asarray(height * np.clip(sum(waves) / 3, 0, None))

    return relief
