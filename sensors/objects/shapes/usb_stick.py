"""A USB stick lying flat, plug out."""

import numpy as np

from sensors.objects.forms import Array, extrude
from sensors.objects.household import register
from sensors.objects.outlines import box, circle
from sensors.objects.textures import grooves


@register(
    "usb-stick",
    title="USB stick",
    family="electronics",
    description="USB stick, 58 x 18 x 8 mm, with grip grooves, a lanyard hole and its 12 mm type-A plug.",
    size_mm=(58.0, 18.0, 8.0),
)
def usb_stick(x: Array, y: Array) -> Array:
    """Plug at +x with its two latch windows; lanyard hole at -x."""
    case = np.maximum(box(x + 7.0, y, 44.0, 18.0, 3.0), -circle(x + 24.5, y, 1.9))
    grip = np.where(box(x + 1.0, y, 18.0, 11.0) < 0.0, grooves(x + 1.0, 2.6, 1.5, 0.45), 0.0)
    body = extrude(case, 8.0 + grip, edge=1.4)
    window = box(x - 22.5, np.abs(y) - 2.75, 2.2, 2.5)
    plug = extrude(box(x - 21.0, y, 16.0, 12.0, 0.3), 6.25 - np.where(window < 0.0, 0.4, 0.0), edge=0.3)
    return np.maximum(body, plug)
