"""What a pressed hyperelastic pad looks like: forces and displacements at its nodes, and on a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import LinearNDInterpolator

from sensors.contact.grid import Grid
from sensors.contact.neohookean.mesh import PadMesh

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PadSolution:
    """A press in equilibrium.

    `displacement` (n, 3) in metres and `internal_force` (n, 3) in newtons at the mesh's nodes; `normal_load` (N, down)
    and `gap` (m) at its top nodes; `residual` in newtons. A quarter mesh holds a quarter of the load.
    """

    mesh: PadMesh
    displacement: Floats
    internal_force: Floats
    normal_load: Floats
    gap: Floats
    indentation_m: float
    iterations: int
    residual: float

    @property
    def force_n(self) -> float:
        """Load of the whole pad (N)."""
        return self.mesh.copies * float(self.normal_load.sum())

    @property
    def base_reaction_n(self) -> float:
        """What the rigid base pushes back with (N): equals `force_n` in equilibrium."""
        return self.mesh.copies * float(self.internal_force[self.mesh.base, 2].sum())

    @property
    def pressure(self) -> Floats:
        """Nominal contact pressure (Pa, force per undeformed area) at the top nodes, (n_top,)."""
        return self.normal_load / self.mesh.top_area

    @property
    def penetration_m(self) -> float:
        """Deepest penetration of a top node."""
        return max(0.0, -float(self.gap.min()))

    def face(self) -> tuple[Floats, Floats]:
        """Deformed positions (x, y) of the top nodes of the whole pad and how far they went down (m): (k, 2), (k,)."""
        moved = self.mesh.nodes[self.mesh.top, :2] + self.displacement[self.mesh.top, :2]
        down = -self.displacement[self.mesh.top, 2]
        if not self.mesh.quarter:
            return moved, down
        signs = [(1, 1), (-1, 1), (1, -1), (-1, -1)]
        return np.concatenate([moved * sign for sign in signs]), np.tile(down, 4)

    def depression(self, grid: Grid) -> Floats:
        """Depth (m) of the deformed top below its rest at the cells of `grid`, (n, n); zero beyond the pad."""
        positions, down = self.face()
        positions, index = np.unique(positions, axis=0, return_index=True)
        out: Floats = LinearNDInterpolator(positions, down[index], fill_value=0.0)(*grid.coordinates())
        return out
