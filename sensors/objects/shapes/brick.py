"""A toy brick of two by four studs."""

import numpy as np

from sensors.objects.forms import Array, extrude
from sensors.objects.household import register
from sensors.objects.outlines import box, circle


@register(
    "toy-brick",
    title="Toy brick",
    family="toy",
    description="Plastic building brick, 2 x 4 studs at 8 mm pitch, 31.8 x 15.8 mm, 11.4 mm with studs.",
    size_mm=(31.8, 15.8, 11.4),
)
def toy_brick(x: Array, y: Array) -> Array:
    """Studs up; every point looks at the stud of its own 8 mm cell."""
    body = extrude(box(x, y, 31.8, 15.8, 0.2), 9.6, edge=0.25)
    u, v = x - 8.0 * np.floor(x / 8.0) - 4.0, y - 8.0 * np.floor(y / 8.0) - 4.0
    stud = np.where((np.abs(x) < 16.0) & (np.abs(y) < 8.0), circle(u, v, 2.4), 1.0)
    return np.maximum(body, extrude(stud, 11.4, edge=0.2))
