"""Two pens lying on the table, longer than the skin is wide."""

import numpy as np

from sensors.objects.forms import Array, extrude, follow, lying_hexagon, turned
from sensors.objects.household import register
from sensors.objects.outlines import box
from sensors.objects.textures import grooves


@register(
    "pen-hexagonal",
    title="Stick pen",
    family="pen",
    description="Capped stick pen, hexagonal 8.3 mm barrel, 150 mm long; cap with its clip on top.",
    size_mm=(150.0, 10.4, 11.0),
    centre_mm=(-17.0, 0.0),
)
def pen_hexagonal(x: Array, y: Array) -> Array:
    """Barrel towards -x, round cap with its clip on top towards +x."""
    barrel = np.where((x > -92.0) & (x < 20.0), lying_hexagon(y, 8.3) + 0.85, 0.0)
    barrel = np.where(barrel > 0.85, barrel, 0.0)
    cap = turned(x, y, [(0.0, 5.0), (0.8, 5.2), (50.0, 4.7), (54.0, 4.2), (57.5, 3.2), (58.0, 2.4)], 5.2)
    clip = extrude(box(x - 28.0, y, 46.0, 3.6, 1.7), follow(x, [(6.0, 10.9), (10.0, 11.0), (51.0, 10.4)]), edge=0.8)
    return np.maximum(barrel, np.maximum(cap, clip))


@register(
    "pen-round",
    title="Click pen",
    family="pen",
    description="Click ballpoint with a round 10.5 mm barrel and a ringed rubber grip, 140 mm long.",
    size_mm=(140.0, 10.5, 10.5),
    centre_mm=(10.0, 0.0),
)
def pen_round(x: Array, y: Array) -> Array:
    """Tip towards -x, ringed grip under the skin, smooth barrel towards +x."""
    knots = [(-60.0, 0.5), (-57.5, 1.2), (-57.0, 2.0), (-45.0, 4.2), (-38.0, 4.7), (-37.9, 5.25), (2.0, 5.25)]
    knots += [(2.05, 4.7), (3.5, 4.7), (3.55, 5.0), (66.0, 4.6), (66.1, 3.0), (80.0, 3.0)]
    grip = np.where((x > -36.0) & (x < 1.0), grooves(x, 2.5, 1.3, 0.45), 0.0)
    return turned(x, y, knots, 5.25, grip)
