"""Bottle caps lying with their tops up."""

import numpy as np

from sensors.objects.forms import Array, bump, follow
from sensors.objects.household import register
from sensors.objects.outlines import circle, star
from sensors.objects.textures import ridges


@register(
    "cap-crown",
    title="Crown cap",
    family="bottle cap",
    description="Pressed steel cap of 21 teeth, 32.1 mm across the skirt and 6 mm high.",
    size_mm=(32.1, 32.1, 6.0),
)
def cap_crown(x: Array, y: Array) -> Array:
    """Flat-domed top with an embossed star; a skirt whose flutes open towards the table."""
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    spread = np.clip((r - 11.5) / 4.55, 0.0, 1.0)
    flute = 1.6 * spread * (0.5 - 0.5 * np.cos(21.0 * angle))
    profile = [
        (0.0, 6.0),
        (9.5, 5.85),
        (11.2, 5.5),
        (12.4, 4.7),
        (13.2, 3.6),
        (14.2, 1.9),
        (16.05, 0.6),
        (16.06, 0.0),
    ]
    emblem = bump(star(x, y, 5, 6.5, 2.7), 0.15)
    top = follow(r + flute, profile)
    return np.where(r + flute < 16.05, np.minimum(top + np.where(r < 9.0, emblem, 0.0), 6.0), 0.0)


@register(
    "cap-screw",
    title="Screw cap",
    family="bottle cap",
    description="Drinks-bottle screw cap, 30 mm across 60 ribs and 14 mm high.",
    size_mm=(30.0, 30.0, 14.0),
)
def cap_screw(x: Array, y: Array) -> Array:
    """Flat top with a raised ring and a gate mark; ribbed side with a little draught."""
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    r_rib = r + 0.4 - ridges(angle, 2.0 * np.pi / 60.0, 0.4)
    profile = [
        (0.0, 13.75),
        (12.6, 13.75),
        (13.4, 13.55),
        (14.0, 13.1),
        (14.3, 12.3),
        (14.7, 4.0),
        (15.0, 0.5),
    ]
    ring = bump(np.abs(circle(x, y, 9.5)) - 0.5, 0.25)
    gate = bump(circle(x, y, 1.2), 0.25)
    return np.where(r_rib < 15.0, follow(r_rib, profile) + np.maximum(ring, gate), 0.0)
