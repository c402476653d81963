"""A wooden clothes peg lying on its side."""

import numpy as np

from sensors.objects.forms import Array, extrude, follow, rod
from sensors.objects.household import register
from sensors.objects.outlines import circle, polyline
from sensors.objects.textures import grooves, noise


@register(
    "clothes-peg",
    title="Clothes peg",
    family="peg",
    description="Wooden spring peg on its side, 72 x 18 mm, two 9.5 mm thick prongs and a steel coil.",
    size_mm=(72.0, 18.0, 11.6),
)
def clothes_peg(x: Array, y: Array) -> Array:
    """Jaws at -x, handles apart at +x; the coil's end and its two arms stand proud of the wood."""
    v = np.abs(y)
    outer = follow(x, [(-36.0, 4.0), (-30.0, 5.6), (-5.0, 6.6), (12.0, 7.6), (36.0, 9.0)])
    inner = follow(x, [(-36.0, 0.25), (-12.0, 0.25), (0.0, 0.5), (4.0, 1.2), (36.0, 5.4)])
    notch = -circle(x + 25.0, y, 2.6)
    prong = np.maximum(np.maximum(v - outer, inner - v), np.maximum(np.abs(x) - 36.0, notch))
    fibre = y + 0.6 * noise(x, y, 14.0, 31)
    grain = 0.12 * noise(0.08 * x, fibre, 0.55, 32) - 0.12
    teeth = np.where((x > 22.0) & (x < 34.0), grooves(x, 3.0, 1.4, 0.35), 0.0)
    wood = extrude(prong, 9.5 + grain + teeth, edge=0.7)
    turns = rod(np.abs(np.hypot(x, y) - 3.2), 0.8, 10.8)
    arm_up = rod(polyline(x, y, [(-2.6, 1.9), (-7.0, 6.2)]), 0.8, 10.5)
    arm_down = rod(polyline(x, y, [(-2.6, -1.9), (-7.0, -6.2)]), 0.8, 10.5)
    core = np.where(np.hypot(x, y) < 2.4, 0.0, wood)
    return np.maximum(core, np.maximum(turns, np.maximum(arm_up, arm_down)))
