"""A walnut in its shell."""

import numpy as np

from sensors.objects.forms import Array, ellipsoid
from sensors.objects.household import register
from sensors.objects.textures import noise


@register(
    "walnut",
    title="Walnut",
    family="food",
    description="Walnut in its shell, 40 x 33 x 32 mm, with a raised seam and wrinkles of half a millimetre.",
    size_mm=(40.0, 33.0, 32.0),
)
def walnut(x: Array, y: Array) -> Array:
    """Seam along x; the wrinkles are the creases of a folded noise, drawn out along the shell."""
    u, v = x + 1.8 * noise(x, y, 5.0, 41), y + 1.8 * noise(y, x, 5.0, 45)
    long_way = np.abs(noise(0.6 * u + 0.5 * v, 0.9 * v - 0.3 * u, 3.6, 42))
    short_way = np.abs(noise(0.8 * u - 0.7 * v, 0.7 * u + 0.8 * v, 4.4, 43))
    wrinkle = -0.8 * np.exp(-((np.minimum(long_way, short_way) / 0.2) ** 2)) - 0.3 * long_way
    seam = np.abs(y - 0.5 * noise(x, 0.0 * y, 7.0, 44))
    ridge = 0.9 * np.exp(-((seam / 1.4) ** 2)) - 0.5 * np.exp(-((seam / 0.35) ** 2))
    shell = ellipsoid(x, y, (20.0, 16.5, 15.7), 15.7)
    calm = np.clip(1.0 - (x / 19.5) ** 2 - (y / 16.0) ** 2, 0.0, 1.0) ** 0.25
    keep = np.clip(seam / 3.0, 0.0, 1.0)
    return np.where(shell > 0.0, np.minimum(shell + calm * (ridge + keep * wrinkle), 32.0), 0.0)
