"""An in-ear earphone lying on its side with a loop of its cable, from a mesh."""

import numpy as np

from sensors.objects.household import register_mesh
from sensors.objects.mesh import Mesh, lathe, merge, rotation, sweep


def _cable() -> Mesh:
    """A 2 mm cable that leaves the stem downwards and comes back round it on the table."""
    t = np.linspace(0.0, 1.0, 240)
    angle = np.pi * (1.0 - 1.7 * t)
    radius = 13.0 + 4.0 * t
    lift = np.interp(t, [0.0, 0.15, 1.0], [4.6, 1.0, 1.0])
    return sweep(np.stack([10.0 + radius * np.cos(angle), 16.0 + radius * np.sin(angle), lift], -1), 1.0)


@register_mesh(
    "earphone",
    title="Earphone",
    family="earphone",
    description="In-ear earphone on its side, 14.5 mm housing, silicone tip, stem, and a loop of 2 mm cable.",
    size_mm=(45.3, 44.5, 14.8),
    centre_mm=(-0.2, 1.0),
)
def earphone() -> Mesh:
    """Housing near the origin, tip towards -x, stem towards +y."""
    housing = [
        (0.0, 7.0),
        (4.5, 6.6),
        (6.6, 5.4),
        (7.25, 3.0),
        (7.25, 0.0),
        (6.4, -3.0),
        (4.4, -5.4),
        (3.2, -7.0),
    ]
    tip = [(3.0, -6.5), (6.3, -7.6), (6.5, -9.0), (6.0, -11.5), (4.4, -13.8), (2.4, -14.8), (2.0, -12.0)]
    lie = rotation("y", 90.0)
    stem = sweep([(-3.0, -4.0, 7.4), (-3.0, 4.0, 6.6), (-3.0, 13.0, 5.2), (-3.0, 17.0, 4.6)], [3.4, 3.0, 2.6, 1.4])
    centred = (-4.0, -8.0, 0.0)
    return merge(
        lathe(housing).moved((-4.0, -6.0, 7.5), lie).moved(centred),
        lathe(tip).moved((-4.0, -6.0, 7.5), lie).moved(centred),
        stem.moved(centred),
        _cable().moved(centred),
    )
