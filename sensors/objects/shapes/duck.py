"""A toy duck lying on its side, from a mesh."""

import numpy as np

from sensors.objects.household import register_mesh
from sensors.objects.mesh import Mesh, ellipsoid, merge, patch, rotation


def _tail(centre: tuple[float, float, float]) -> Mesh:
    """An upturned cone, rounded at its tip."""
    s = np.linspace(0.0, 1.0, 25)[:, None]
    angle = np.linspace(0.0, 2.0 * np.pi, 49)[None, :]
    radius = 9.0 * np.sqrt(1.0 - s**1.5)
    points = np.broadcast_arrays(
        centre[0] - 16.0 * s + 0.0 * angle,
        centre[1] - 7.0 * s**2 + 0.8 * radius * np.sin(angle),
        centre[2] + radius * np.cos(angle),
    )
    return patch(np.stack(points, -1))


@register_mesh(
    "toy-duck",
    title="Toy duck",
    family="toy",
    description="Rubber duck on its side, 58 x 47 mm: body, wing, head with an eye, beak and tail.",
    size_mm=(58.0, 47.0, 27.0),
)
def toy_duck() -> Mesh:
    """Beak towards +x, top of the head towards -y; the body's flank is the highest point."""
    middle = 13.0
    wing = ellipsoid((0.0, 0.0, 0.0), (11.0, 6.5, 3.5)).moved((-6.5, 7.5, 23.5), rotation("z", 14.0))
    return merge(
        ellipsoid((-4.5, 9.0, middle), (20.0, 14.5, 12.5)),
        ellipsoid((9.0, -10.5, middle), (13.0, 13.0, 12.0)),
        ellipsoid((6.0, 0.0, middle), (10.5, 9.0, 10.5)),
        ellipsoid((22.0, -8.5, middle), (7.0, 2.6, 6.0)),
        ellipsoid((21.0, -5.5, middle), (5.5, 2.0, 5.0)),
        ellipsoid((12.5, -13.0, middle + 10.6), (2.2, 2.6, 1.6)),
        _tail((-13.0, 5.0, middle)),
        wing,
    )
