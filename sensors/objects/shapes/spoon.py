"""A teaspoon lying with its bowl up, from a mesh."""

import numpy as np

from sensors.objects.household import register_mesh
from sensors.objects.mesh import Mesh, merge, patch


def _handle() -> Mesh:
    """A shallow arched bar from the bowl's rim to the end of the handle."""
    x = np.linspace(-3.0, 92.0, 200)[:, None]
    across = np.linspace(-1.0, 1.0, 33)[None, :]
    half = np.interp(x, [-3.0, 4.0, 12.0, 30.0, 75.0, 86.0, 90.5, 92.0], [6.5, 4.2, 3.0, 3.0, 6.2, 6.6, 4.6, 0.5])
    spine = np.interp(x, [-3.0, 2.0, 12.0, 22.0, 45.0, 92.0], [6.6, 7.4, 8.6, 9.0, 8.2, 3.0])
    crown = 1.2 * np.sqrt(1.0 - 0.96 * across**2)
    return patch(np.stack(np.broadcast_arrays(x, half * across, spine - 1.2 + crown), -1))


def _bowl() -> Mesh:
    """An egg-shaped shell with a rounded rim: inner face, rim and outer face in one sheet."""
    angle = np.linspace(0.0, 2.0 * np.pi, 193)[None, :]
    reach = np.linspace(0.0, 1.0, 49)[:, None]
    outline_x = -22.0 + 22.0 * np.cos(angle)
    outline_y = 15.5 * np.sin(angle) * (1.0 - 0.13 * np.cos(angle))
    rim = 7.6 + 0.5 * np.cos(angle)
    inner = 1.2 + (rim - 1.2) * reach**2.4
    x, y = -22.0 + (outline_x + 22.0) * reach, outline_y * reach
    face = patch(np.stack([x, y, np.broadcast_to(inner, x.shape)], -1))
    turn = np.linspace(0.0, np.pi, 13)[:, None]
    swell = 0.6 * np.sin(turn)
    lip_x = -22.0 + (outline_x + 22.0) * (0.985 - 0.015 * np.cos(turn))
    lip_y = outline_y * (0.98 - 0.02 * np.cos(turn))
    lip = patch(np.stack([lip_x, lip_y, np.broadcast_to(rim + swell, lip_x.shape)], -1))
    return merge(face, lip)


@register_mesh(
    "spoon",
    title="Teaspoon",
    family="cutlery",
    description="Teaspoon, bowl up, 136 mm long: the egg-shaped rim of a 44 x 31 mm bowl, and the neck.",
    size_mm=(136.0, 31.3, 9.0),
    centre_mm=(30.0, 0.0),
)
def spoon() -> Mesh:
    """Tip of the bowl at x = -38, end of the handle at x = 98."""
    return merge(_bowl(), _handle()).moved((6.0, 0.0, 0.0))
