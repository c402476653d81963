"""A coat button."""

import numpy as np

from sensors.objects.forms import Array, bump, upright
from sensors.objects.household import register
from sensors.objects.outlines import circle


@register(
    "button",
    title="Coat button",
    family="button",
    description="Four-hole coat button, 23 x 3.4 mm, dished inside a round rim: as wide as a 1 euro coin.",
    size_mm=(23.0, 23.0, 3.4),
)
def button(x: Array, y: Array) -> Array:
    """Rim up; the four holes go through to the table."""
    profile = [
        (0.0, 2.1),
        (6.0, 2.15),
        (7.2, 2.4),
        (8.4, 3.2),
        (9.4, 3.4),
        (10.4, 3.1),
        (11.1, 2.3),
        (11.5, 1.0),
    ]
    hole = circle(np.abs(x) - 2.2, np.abs(y) - 2.2, 1.1)
    body = upright(x, y, profile) + bump(np.abs(circle(x, y, 5.2)) - 0.15, 0.12)
    return np.where((hole < 0.0) | (np.hypot(x, y) >= 11.5), 0.0, np.minimum(body, 3.4))
