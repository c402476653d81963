"""Round cells lying on the table (IEC 60086: LR6 and LR03)."""

import numpy as np

from sensors.objects.forms import Array, turned
from sensors.objects.household import register


def _cell(x: Array, y: Array, diameter: float, length: float, button: tuple[float, float]) -> Array:
    """A cell with its positive button (diameter, height) at +x, a film label and a crimp under the button."""
    radius, end = 0.5 * diameter, 0.5 * length
    can, shoulder = radius - 0.12, end - button[1]
    knots = [
        (-end, 0.55 * radius),
        (-end + 0.3, can - 0.5),
        (-end + 0.8, can),
        (-end + 1.5, can),
        (-end + 1.52, radius),
        (shoulder - 2.6, radius),
        (shoulder - 2.58, can),
        (shoulder - 2.0, can - 0.35),
        (shoulder - 1.4, can),
        (shoulder - 0.4, can),
        (shoulder, can - 0.5),
        (shoulder + 0.02, 0.5 * button[0]),
        (end, 0.5 * button[0] - 0.15),
    ]
    seam = 0.08 * np.exp(-(((y - 0.25 * diameter) / 0.35) ** 2)) * (np.abs(x) < end - 4.0)
    body = turned(x, y, knots, radius)
    return np.minimum(np.where(body > 0.0, body + seam, 0.0), diameter)


@register(
    "battery-aa",
    title="AA battery",
    family="battery",
    description="Alkaline LR6 cell, 14.5 x 50.5 mm, with a label seam and a 5.5 mm button.",
    size_mm=(50.5, 14.5, 14.5),
)
def battery_aa(x: Array, y: Array) -> Array:
    """AA cell along x, button at +x."""
    return _cell(x, y, 14.5, 50.5, (5.5, 1.0))


@register(
    "battery-aaa",
    title="AAA battery",
    family="battery",
    description="Alkaline LR03 cell, 10.5 x 44.5 mm: the AA cell's smaller double.",
    size_mm=(44.5, 10.5, 10.5),
)
def battery_aaa(x: Array, y: Array) -> Array:
    """AAA cell along x, button at +x."""
    return _cell(x, y, 10.5, 44.5, (3.8, 0.8))
