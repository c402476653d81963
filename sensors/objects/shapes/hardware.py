"""A hexagon bolt and a hexagon nut."""

import numpy as np

from sensors.objects.forms import Array, extrude, follow, lying_hexagon, turned
from sensors.objects.household import register
from sensors.objects.outlines import circle, regular
from sensors.objects.textures import figures


@register(
    "hex-bolt",
    title="Hex bolt M10",
    family="hardware",
    description="M10 x 40 bolt lying on a flat of its 16 mm head (ISO 4017), thread pitch 1.5 mm.",
    size_mm=(46.4, 18.48, 16.0),
)
def hex_bolt(x: Array, y: Array) -> Array:
    """Head at -x; the thread is a true helix, so that its crests lean over the visible side."""
    around = np.arcsin(np.clip(y / 5.0, -1.0, 1.0))
    phase = (x / 1.5 - around / (2.0 * np.pi)) % 1.0
    thread = np.where(x > -15.0, -0.92 * np.clip(np.abs(2.0 * phase - 1.0) * 1.15 - 0.1, 0.0, 1.0), 0.0)
    shank = turned(x, y, [(-17.0, 4.9), (21.8, 4.9), (23.2, 3.8)], 8.0, thread)
    bevel = follow(x, [(-23.2, 1.0), (-22.2, 0.0)])
    head = np.where((x > -23.2) & (x < -16.8), np.maximum(lying_hexagon(y, 16.0) - bevel, 0.0), 0.0)
    return np.maximum(shank, head)


@register(
    "hex-nut",
    title="Hex nut M12",
    family="hardware",
    description="M12 nut lying flat, 18 mm across flats and 10.8 mm high (ISO 4032), chamfered, 12 mm hole.",
    size_mm=(18.0, 20.79, 10.8),
)
def hex_nut(x: Array, y: Array) -> Array:
    """Across flats along x; a 30 degree chamfer takes the corners down, a mark is stamped beside the hole."""
    r = np.hypot(x, y)
    face = follow(r, [(5.1, 9.8), (6.2, 10.8), (8.6, 10.8), (10.6, 9.65)]) - figures(
        x, y + 7.4, "10", (0.9, 1.5), 0.3, 0.15
    )
    outline = np.maximum(regular(x, y, 6, 18.0), -circle(x, y, 5.1))
    return extrude(outline, face, edge=0.15)
