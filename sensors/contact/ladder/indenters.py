"""The classes of indenter that the ladder is measured with, in units of the pad's thickness."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sensors.contact.grid import Grid
from sensors.contact.ladder.interface import Pad
from sensors.contact.neohookean.surface import Surface, SweptSurface

_ALIKE = 1e-6
"""How far, in thicknesses, a surface may differ from a representative and still be it."""

INDENTER_CLASSES: dict[str, SweptSurface] = {
    "sphere": SweptSurface(tip_radius_m=2.0),
    "flat-punch": SweptSurface(tip_radius_m=0.3, core_radius_m=0.7),
    "edge": SweptSurface(tip_radius_m=0.5, half_length_m=1.0),
    "cylinder": SweptSurface(tip_radius_m=1.5, half_length_m=1.0),
}
"""Radius of the rounded edge, half length of the segment and radius of the flat core, each over the thickness."""


def indenter(indenter_class: str, thickness_m: float) -> SweptSurface:
    """The representative of a class for a pad of `thickness_m`; ValueError for an unknown class."""
    if indenter_class not in INDENTER_CLASSES:
        raise ValueError(f"unknown indenter class {indenter_class!r}; known: {', '.join(INDENTER_CLASSES)}")
    unit = INDENTER_CLASSES[indenter_class]
    return SweptSurface(
        unit.tip_radius_m * thickness_m, unit.half_length_m * thickness_m, unit.core_radius_m * thickness_m
    )


def areas_below(surface: Surface, depths_m: Sequence[float], pad: Pad) -> list[float]:
    """Area (m^2) over `pad` in which the gap of `surface` is less than each depth."""
    grid = Grid(256, pad.side_m)
    gap = surface.jet(*grid.coordinates()).gap
    return [float((gap < depth).sum()) * grid.cell_area_m2 for depth in depths_m]


def is_representative(surface: Surface, indenter_class: str, pad: Pad) -> bool:
    """Whether `surface` is the representative of its class on the axis of `pad`; ValueError for an unknown class."""
    thickness = pad.material.thickness_m
    x, y = Grid(64, pad.side_m).coordinates()
    off = np.abs(surface.jet(x, y).gap - indenter(indenter_class, thickness).jet(x, y).gap)
    return bool(off.max() <= _ALIKE * thickness)
