"""A toothbrush lying with its bristles up."""

import numpy as np

from sensors.objects.forms import Array, extrude, follow
from sensors.objects.household import register
from sensors.objects.outlines import box, circle
from sensors.objects.textures import noise


@register(
    "toothbrush",
    title="Toothbrush",
    family="grooming",
    description="Bristles up: 3 x 9 tufts of 2.3 mm on a 36 x 13 mm head, 16 mm high; its neck.",
    size_mm=(110.0, 13.0, 16.0),
    centre_mm=(37.0, 0.0),
)
def toothbrush(x: Array, y: Array) -> Array:
    """Head about the origin, neck and the start of the handle towards +x; tufts differ a little in length."""
    half = follow(x, [(14.0, 6.5), (22.0, 3.0), (38.0, 2.6), (60.0, 5.5), (92.0, 5.5)])
    neck = np.maximum(np.abs(y) - half, np.maximum(12.0 - x, x - 92.0))
    head = np.minimum(box(x, y, 36.0, 13.0, 6.0), neck)
    body = extrude(head, follow(x, [(18.0, 5.0), (30.0, 6.0), (60.0, 9.0), (92.0, 9.0)]), edge=1.8)
    row = np.clip(np.round(y / 3.4), -1.0, 1.0)
    column = np.clip(np.round(x / 3.3), -4.0, 4.0)
    u, v = x - 3.3 * column, y - 3.4 * row
    tip = 15.3 + 0.5 * np.cos(np.pi * column) + 0.1 * noise(x, y, 0.35, 5)
    tuft = extrude(circle(u, v, 1.15), tip, edge=0.5)
    return np.maximum(body, np.minimum(tuft, 16.0))
