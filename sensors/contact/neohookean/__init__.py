"""The `neohookean` rung: a hyperelastic pad in three dimensions, pressed by a rigid surface.

Trilinear hexahedra with one pressure each (Q1P0, mean dilatation), bonded base, frictionless unilateral contact at the
nodes of the top, Newton with the consistent tangent, sparse direct solver.
"""

from sensors.contact.neohookean.material import NeoHookean
from sensors.contact.neohookean.mesh import HexMesh, PadMesh, brick, graded_pad
from sensors.contact.neohookean.pad import NeoHookeanPad
from sensors.contact.neohookean.solution import PadSolution
from sensors.contact.neohookean.surface import GridSurface, Surface, SurfaceJet, SweptSurface

__all__ = [
    "GridSurface",
    "HexMesh",
    "NeoHookean",
    "NeoHookeanPad",
    "PadMesh",
    "PadSolution",
    "Surface",
    "SurfaceJet",
    "SweptSurface",
    "brick",
    "graded_pad",
]
