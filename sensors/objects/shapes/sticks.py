"""Twist-up sticks lying on the table: a glue stick, and a lip balm that is nearly an AA battery."""

import numpy as np

from sensors.objects.forms import Array, turned
from sensors.objects.household import register
from sensors.objects.textures import ridges


def _ribs(x: Array, y: Array, span: tuple[float, float], radius: float, count: int, height: float) -> Array:
    """Ribs along the axis, evenly spaced round a body of `radius`, between two positions on x."""
    around = np.arcsin(np.clip(y / radius, -1.0, 1.0))
    return np.where((x > span[0]) & (x < span[1]), ridges(around, 2.0 * np.pi / count, height) - height, 0.0)


@register(
    "glue-stick",
    title="Glue stick",
    family="stick",
    description="Glue stick with its cap on, 22 x 90 mm, ribbed cap and a ribbed twist knob.",
    size_mm=(90.0, 22.0, 22.0),
)
def glue_stick(x: Array, y: Array) -> Array:
    """Knob at -x, cap at +x; the cap's step lies just beyond the middle."""
    knots = [
        (-45.0, 9.5),
        (-44.2, 10.2),
        (-37.0, 10.2),
        (-36.9, 8.8),
        (-36.0, 8.8),
        (-35.9, 10.0),
        (9.0, 10.0),
    ]
    knots += [(9.05, 9.3), (10.0, 9.3), (10.05, 11.0), (43.5, 11.0), (44.6, 10.4), (45.0, 9.4)]
    relief = _ribs(x, y, (15.0, 41.0), 11.0, 40, 0.5) + _ribs(x, y, (-44.0, -37.2), 10.2, 48, 0.5)
    return turned(x, y, knots, 11.0, relief)


@register(
    "lip-balm",
    title="Lip balm",
    family="stick",
    description="Lip balm tube with its cap on, 16 x 67 mm: close to an AA battery under the skin.",
    size_mm=(67.0, 16.0, 16.0),
)
def lip_balm(x: Array, y: Array) -> Array:
    """Twist wheel at -x, smooth cap at +x."""
    knots = [(-33.5, 7.2), (-33.0, 7.7), (-28.0, 7.7), (-27.95, 6.9), (-27.2, 6.9), (-27.15, 7.8), (6.0, 7.8)]
    knots += [(6.05, 7.2), (6.7, 7.2), (6.75, 8.0), (32.6, 8.0), (33.2, 7.7), (33.5, 7.0)]
    return turned(x, y, knots, 8.0, _ribs(x, y, (-32.8, -28.1), 7.7, 36, 0.4))
