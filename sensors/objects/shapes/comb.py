"""A pocket comb lying flat."""

import numpy as np

from sensors.objects.forms import Array, extrude, follow
from sensors.objects.household import register
from sensors.objects.outlines import box


@register(
    "comb",
    title="Pocket comb",
    family="grooming",
    description="Plastic comb, 125 x 28 mm, 4 mm spine, coarse teeth (2.4 mm pitch) and fine teeth (1.5 mm).",
    size_mm=(125.0, 28.0, 4.0),
)
def comb(x: Array, y: Array) -> Array:
    """Spine towards -y; coarse teeth for x < 0, fine teeth for x > 0, thinning to their tips."""
    plate = box(x, y, 125.0, 28.0, 3.0)
    pitch = np.where(x < 0.0, 2.4, 1.5)
    fill = np.where(x < 0.0, 0.62, 0.6) * follow(y, [(-4.0, 1.0), (8.0, 0.95), (14.0, 0.55)])
    offset = np.abs(x - pitch * (np.floor(x / pitch) + 0.5))
    gap = (0.5 * fill * pitch - offset) * ((np.abs(x) < 57.6) & (y > -4.0)) + 10.0 * ((np.abs(x) >= 57.6) | (y <= -4.0))
    thickness = follow(y, [(-14.0, 3.4), (-11.0, 4.0), (-7.0, 4.0), (-4.0, 3.0), (14.0, 1.8)])
    return extrude(np.maximum(plate, -gap), thickness, edge=0.35)
