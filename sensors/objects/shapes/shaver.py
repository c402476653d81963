"""The head of a rotary shaver standing face up, from a mesh."""

import numpy as np

from sensors.objects.household import register_mesh
from sensors.objects.mesh import Mesh, merge, patch

_CUTTER_RADIUS = 11.0
_CUTTER_AT = 14.0


def _housing() -> Mesh:
    """A rounded triangle with a flat top and a rounded shoulder."""
    angle = np.linspace(0.0, 2.0 * np.pi, 241)[None, :]
    reach = np.array([0.0, 0.4, 0.8, 0.9, 0.95, 0.98, 1.0, 1.0])[:, None]
    level = np.array([14.0, 14.0, 14.0, 13.6, 12.8, 11.6, 9.5, 0.0])[:, None]
    outline = 26.5 + 2.5 * np.cos(3.0 * angle)
    return patch(
        np.stack(np.broadcast_arrays(reach * outline * np.cos(angle), reach * outline * np.sin(angle), level), -1)
    )


def _cutter(x: float, y: float) -> Mesh:
    """A raised disc with two rings of radial slots, 48 slots each 0.5 mm deep, about a plain hub."""
    radius = np.linspace(0.0, _CUTTER_RADIUS, 111)[:, None]
    angle = np.linspace(0.0, 2.0 * np.pi, 577)[None, :]
    dish = np.interp(
        radius,
        [0.0, 3.4, 3.6, 6.6, 7.0, 7.4, 10.2, 10.7, 11.0],
        [16.6, 16.6, 16.9, 17.0, 16.3, 17.0, 16.9, 16.2, 14.0],
    )
    slotted = ((radius > 4.0) & (radius < 6.4)) | ((radius > 7.7) & (radius < 10.0))
    slots = np.clip(2.0 * np.cos(48.0 * angle), 0.0, 1.0)
    z = dish - 0.5 * slotted * slots
    return patch(np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle), z], -1))


@register_mesh(
    "shaver",
    title="Shaver head",
    family="shaver",
    description="Head of a rotary shaver, three 22 mm cutters with slotted rings on a rounded triangle.",
    size_mm=(53.0, 54.7, 17.0),
    centre_mm=(2.5, 0.0),
)
def shaver() -> Mesh:
    """Cutters at 0, 120 and 240 degrees; faces up."""
    turns = 2.0 * np.pi * np.arange(3) / 3.0
    return merge(_housing(), *(_cutter(_CUTTER_AT * np.cos(a), _CUTTER_AT * np.sin(a)) for a in turns))
