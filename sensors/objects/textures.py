"""Fine relief in millimetres, added to a form: ridges, grooves, noise of a fixed seed, figures."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sensors.objects.forms import bump
from sensors.objects.outlines import Point, polyline

Array = NDArray[np.float64]

_PERIOD = 64
_ROUND = [(0.0, -1.0), (-0.75, -0.6), (-1.0, 0.0), (-0.75, 0.6), (0.0, 1.0)]
_ROUND += [(0.75, 0.6), (1.0, 0.0), (0.75, -0.6), (0.0, -1.0)]

_FIGURES: dict[str, list[Point]] = {
    "0": [(0.5 + 0.47 * u, 0.5 + 0.5 * v) for u, v in _ROUND],
    "1": [(0.2, 0.25), (0.55, 0.0), (0.55, 1.0)],
    "2": [(0.05, 0.25), (0.25, 0.03), (0.7, 0.03), (0.92, 0.25), (0.85, 0.45), (0.05, 1.0), (1.0, 1.0)],
}
"""Strokes of the digits in a unit square, y downwards."""


def ridges(position: Array, pitch: float, height: float) -> Array:
    """Rounded ridges across `position`, from 0 to `height`."""
    return 0.5 * height * (1.0 + np.cos(2.0 * np.pi * position / pitch))


def grooves(position: Array, pitch: float, width: float, depth: float) -> Array:
    """Narrow grooves, one a pitch and centred on its multiples: 0 between them, -depth at their bottom."""
    offset = np.abs(position - pitch * np.round(position / pitch))
    return -depth * np.clip(1.0 - (2.0 * offset / width) ** 2, 0.0, 1.0)


def noise(x: Array, y: Array, grain: float, seed: int) -> Array:
    """Smooth noise in [-1, 1] with features of about `grain`; the same values on every machine."""
    u, v = np.asarray(x) / grain, np.asarray(y) / grain
    i, j = np.floor(v).astype(int), np.floor(u).astype(int)
    s, t = v - i, u - j
    s, t = s * s * s * (s * (6.0 * s - 15.0) + 10.0), t * t * t * (t * (6.0 * t - 15.0) + 10.0)
    table = _lattice(seed)
    i, j = i % _PERIOD, j % _PERIOD
    k, m = (i + 1) % _PERIOD, (j + 1) % _PERIOD
    upper = (1.0 - t) * table[i, j] + t * table[i, m]
    lower = (1.0 - t) * table[k, j] + t * table[k, m]
    return np.asarray((1.0 - s) * upper + s * lower)


def figures(x: Array, y: Array, text: str, size: tuple[float, float], stroke: float, height: float) -> Array:
    """Digits of width and height `size` about the origin, drawn with a stroke and raised by `height`."""
    width, tall = size
    advance = 1.3 * width
    relief = np.zeros(np.broadcast_shapes(np.shape(x), np.shape(y)))
    for place, figure in enumerate(text):
        left = (place - 0.5 * (len(text) - 1)) * advance - 0.5 * width
        chain = [(left + width * u, tall * (v - 0.5)) for u, v in _FIGURES[figure]]
        relief = np.maximum(relief, bump(polyline(x, y, chain) - 0.5 * stroke, height))
    return relief


@lru_cache(maxsize=32)
def _lattice(seed: int) -> Array:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (_PERIOD, _PERIOD))
