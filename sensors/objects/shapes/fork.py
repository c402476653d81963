"""A dessert fork lying with its tines up."""

import numpy as np

from sensors.objects.forms import Array, extrude, follow
from sensors.objects.household import register
from sensors.objects.outlines import box

_ARCH = [(-40.0, 6.3), (-34.0, 5.0), (-26.0, 4.0), (-16.0, 3.7), (-4.0, 4.6), (6.0, 6.4), (14.0, 7.6)]
_ARCH += [(20.0, 8.0), (30.0, 7.8), (60.0, 5.4), (90.0, 3.0)]
"""Height of the middle line along the fork, millimetres."""


@register(
    "fork",
    title="Fork",
    family="cutlery",
    description="Dessert fork of four tines, 130 mm of it on the raster, tines 2.4 mm wide and 40 mm long.",
    size_mm=(130.0, 21.6, 8.0),
    centre_mm=(25.0, 0.0),
)
def fork(x: Array, y: Array) -> Array:
    """Tine tips at x = -40, handle towards +x; the head arches and the neck rises from it."""
    half = follow(x, [(-8.0, 11.0), (-2.0, 10.7), (3.0, 9.0), (9.0, 5.0), (15.0, 3.4), (35.0, 3.0), (90.0, 6.0)])
    palm = np.maximum(np.abs(y) - half, np.maximum(-6.0 - x, x - 90.0))
    v = y - 6.2 * np.clip(np.round(y / 6.2 - 0.5) + 0.5, -1.5, 1.5)
    tines = np.maximum(np.abs(v) - follow(x, [(-40.0, 0.6), (-30.0, 1.15), (-5.0, 1.5)]), box(x + 20.0, y, 40.0, 22.0))
    arch = follow(x, _ARCH)
    bowl = arch + 0.8 * np.minimum((y / 10.0) ** 2, 1.0) * (x < 5.0)
    return np.minimum(extrude(np.minimum(palm, tines), bowl, edge=0.7), 8.0)
