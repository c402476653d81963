"""Two flat door keys."""

import numpy as np

from sensors.objects.forms import Array, bump, extrude, follow
from sensors.objects.household import register
from sensors.objects.outlines import box, circle
from sensors.objects.textures import figures, grooves


def _cuts(x: Array, start: float, pitch: float, depths: list[float]) -> Array:
    """Depth of the bitting along the blade: flat-bottomed V cuts, one a pitch."""
    cut = np.zeros(np.shape(x))
    for place, depth in enumerate(depths):
        off = np.abs(x - start - pitch * place)
        cut = np.maximum(cut, depth - 1.1 * np.maximum(off - 0.5, 0.0))
    return cut


@register(
    "key-round",
    title="House key",
    family="key",
    description="Pin-tumbler key with a round 25 mm bow, 57 mm long and 2.3 mm thick, cut on one edge.",
    size_mm=(57.0, 25.0, 2.3),
)
def key_round(x: Array, y: Array) -> Array:
    """Bow at -x, tip at +x, cuts towards -y, a milled groove along the blade."""
    bow = np.maximum(circle(x + 16.0, y, 12.5), -circle(x + 22.5, y, 3.5))
    neck = box(x + 1.5, y, 9.0, 11.0, 1.0)
    cut = _cuts(x, 6.5, 4.0, [1.8, 3.0, 1.2, 2.4, 3.2])
    tip = np.maximum(x - 28.5 + 0.9 * np.abs(y - 0.8), np.abs(y) - 4.25)
    blade = np.maximum(np.maximum(tip, -x - 2.0), -(y + 4.25 - cut))
    milled = follow(x, [(0.0, 0.0), (1.5, 0.7), (28.0, 0.7)]) * np.exp(-(((y - 1.6) / 0.8) ** 4))
    emblem = bump(np.abs(circle(x + 14.5, y, 4.2)) - 0.35, 0.2) + figures(x + 14.5, y, "20", (1.9, 3.4), 0.6, 0.2)
    bow_plate = extrude(np.minimum(bow, neck), 2.1 + np.where(x < -8.0, np.minimum(emblem, 0.2), 0.0), edge=0.4)
    return np.maximum(bow_plate, extrude(blade, 2.3 - milled, edge=0.15))


@register(
    "key-square",
    title="Padlock key",
    family="key",
    description="Small padlock key with a square bow, 45 mm long and 2 mm thick, cut on both edges.",
    size_mm=(45.0, 20.0, 2.0),
)
def key_square(x: Array, y: Array) -> Array:
    """Bow at -x, tip at +x, cuts on both edges, ribs across the bow."""
    bow = np.maximum(box(x + 12.5, y, 20.0, 20.0, 3.5), -box(x + 18.5, y, 3.0, 9.0, 1.4))
    upper = _cuts(x, 5.0, 3.2, [1.0, 1.7, 0.6, 1.5, 1.1])
    lower = _cuts(x, 4.0, 3.2, [1.6, 0.7, 1.4, 1.8, 0.8])
    tip = np.maximum(x - 22.5 + 0.8 * np.maximum(np.abs(y) - 0.8, 0.0), np.abs(y) - 3.5)
    blade = np.maximum(np.maximum(tip, -x - 3.5), np.maximum(-(y + 3.5 - lower), y - 3.5 + upper))
    ribs = np.where(box(x + 10.0, y, 9.0, 14.0) < 0.0, grooves(x + 10.0, 1.8, 1.0, 0.25), 0.0)
    keyway = 0.5 * np.exp(-((y / 0.7) ** 4)) * (x > 0.0)
    return np.maximum(extrude(bow, 2.0 + ribs, edge=0.35), extrude(blade, 1.9 - keyway, edge=0.15))
