"""Three euro coins, value side up (diameters and thicknesses of the European Central Bank)."""

import numpy as np

from sensors.objects.forms import Array, bump, extrude
from sensors.objects.household import register
from sensors.objects.outlines import circle, star
from sensors.objects.textures import figures, noise

_FIELD_DEPTH = 0.18
_RELIEF = 0.15


def _rim(edge: Array, thickness: float, relief: Array) -> Array:
    """A struck disc: full thickness at its rim, the field sunk below it and the relief upon the field."""
    sunk = bump(edge + 1.2, _FIELD_DEPTH)
    face = thickness - sunk + np.where(edge < -1.0, np.minimum(relief, sunk), 0.0)
    return extrude(edge, face, edge=0.25)


def _stars(x: Array, y: Array, radius: float, count: int) -> Array:
    """Raised stars on a circle; each point looks only at its nearest star."""
    sector = 2.0 * np.pi / count
    angle = np.arctan2(y, x)
    offset = angle - sector * np.round(angle / sector)
    r = np.hypot(x, y)
    return bump(star(r * np.sin(offset), radius - r * np.cos(offset), 5, 0.95, 0.4), 0.12, slope=0.1)


def _land(x: Array, y: Array, radius: float, seed: int) -> Array:
    """The map side of the field: low land with a broken coast, to the right of the figure."""
    coast = noise(x, y, 2.6, seed) + 0.4 * noise(x, y, 1.1, seed + 1)
    inside = np.minimum(coast - 0.05, 0.5 * (radius - 0.8 - np.hypot(x, y)))
    return bump(-np.minimum(inside, 0.6 * (x - 0.1 * radius)), 0.1, slope=0.2)


@register(
    "coin-1-euro",
    title="1 euro coin",
    family="coin",
    description="Two-metal coin, 23.25 x 2.33 mm, figure 1 and map in a 16.25 mm core.",
    size_mm=(23.25, 23.25, 2.33),
)
def coin_1_euro(x: Array, y: Array) -> Array:
    """1 euro, value side up."""
    groove = -bump(np.abs(np.hypot(x, y) - 8.125) - 0.1, 0.08)
    relief = np.maximum(figures(x + 3.6, y, "1", (4.5, 10.0), 1.5, _RELIEF), _land(x, y, 8.125, 11))
    return _rim(circle(x, y, 11.625), 2.33, np.maximum(relief, _stars(x, y, 9.4, 12)) + groove)


@register(
    "coin-2-euro",
    title="2 euro coin",
    family="coin",
    description="Two-metal coin, 25.75 x 2.20 mm, figure 2 and map in an 18.75 mm core.",
    size_mm=(25.75, 25.75, 2.2),
)
def coin_2_euro(x: Array, y: Array) -> Array:
    """2 euro, value side up."""
    groove = -bump(np.abs(np.hypot(x, y) - 9.375) - 0.1, 0.08)
    relief = np.maximum(figures(x + 3.9, y, "2", (5.6, 10.5), 1.5, _RELIEF), _land(x, y, 9.375, 11))
    return _rim(circle(x, y, 12.875), 2.2, np.maximum(relief, _stars(x, y, 10.6, 12)) + groove)


@register(
    "coin-20-cent",
    title="20 cent coin",
    family="coin",
    description="Brass coin of Spanish-flower shape, 22.25 x 2.14 mm, seven notches in its edge.",
    size_mm=(22.25, 22.25, 2.14),
)
def coin_20_cent(x: Array, y: Array) -> Array:
    """20 cent, value side up."""
    sector = 2.0 * np.pi / 7.0
    angle = np.arctan2(y, x)
    offset = angle - sector * np.round(angle / sector)
    notch = 0.55 * np.exp(-((11.1 * offset / 0.8) ** 2))
    relief = np.maximum(figures(x + 2.6, y, "20", (4.2, 7.5), 1.1, _RELIEF), _land(x - 2.0, y, 7.5, 17))
    return _rim(circle(x, y, 11.125) + notch, 2.14, relief)
