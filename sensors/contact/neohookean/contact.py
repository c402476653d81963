"""Frictionless unilateral contact of the top nodes with a rigid surface, by an augmented Lagrangian.

A top node at (x, y, z) keeps phi = gap(x, y) - d - u_z >= 0. With a multiplier l (N) and a stiffness s (N/m) per node
the potential is sum (<l - s phi>^2 - l^2) / (2 s); its force <l - s phi> grad phi is normal to the surface, and its
vertical part is <l - s phi> itself. Source: P. Wriggers, "Computational Contact Mechanics" (2006), sections 5.3, 6.3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from sensors.contact.neohookean.mesh import PadMesh
from sensors.contact.neohookean.surface import Surface, SurfaceJet

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class TopContact:
    """Contact of the top of `mesh` with `surface`; `multiplier` (N) and `stiffness` (N/m) per top node, (n_top,)."""

    mesh: PadMesh
    surface: Surface
    multiplier: Floats
    stiffness: Floats

    def _phi(self, displacement: Floats, indentation_m: float) -> tuple[Floats, SurfaceJet]:
        moved = self.mesh.nodes[self.mesh.top] + displacement[self.mesh.top]
        jet = self.surface.jet(moved[:, 0], moved[:, 1])
        return jet.gap - indentation_m - displacement[self.mesh.top, 2], jet

    def gap(self, displacement: Floats, indentation_m: float) -> Floats:
        """phi (m) of the top nodes, (n_top,): negative where the surface is penetrated."""
        return self._phi(displacement, indentation_m)[0]

    def normal_load(self, gap: Floats) -> Floats:
        """Vertical force (N) that each top node carries at a given `gap`, (n_top,); never negative."""
        return np.maximum(self.multiplier - self.stiffness * gap, 0)

    def energy(self, displacement: Floats, indentation_m: float) -> float:
        """Potential of the contact (J)."""
        load = self.normal_load(self.gap(displacement, indentation_m))
        return float(((load**2 - self.multiplier**2) / (2 * self.stiffness)).sum())

    def force(self, displacement: Floats, indentation_m: float) -> tuple[Floats, float]:
        """Derivatives of `energy` by the top nodes' displacements (n_top, 3), and by the indentation."""
        phi, jet = self._phi(displacement, indentation_m)
        load = self.normal_load(phi)
        slope = np.concatenate([jet.gradient, -np.ones((len(load), 1))], axis=1)
        return -load[:, None] * slope, float(load.sum())

    def hessian(self, displacement: Floats, indentation_m: float, place: NDArray[np.int64]) -> sp.csc_matrix:
        """Second derivative of `energy`.

        `place` (n_dof,) gives the row of each degree of freedom, -1 where it is held; the indentation has the last.
        """
        phi, jet = self._phi(displacement, indentation_m)
        load = self.normal_load(phi)
        touching = np.flatnonzero(load > 0)
        slope = np.full((len(touching), 4), -1.0)
        slope[:, :2] = jet.gradient[touching]
        blocks = self.stiffness[touching, None, None] * slope[:, :, None] * slope[:, None, :]
        blocks[:, :2, :2] -= load[touching, None, None] * jet.hessian[touching]
        size = int(place.max()) + 2
        dofs = place[3 * self.mesh.top[touching, None] + np.arange(3)]
        dofs = np.concatenate([dofs, np.full((len(touching), 1), size - 1)], axis=1)
        rows = np.broadcast_to(dofs[:, :, None], blocks.shape)
        columns = np.broadcast_to(dofs[:, None, :], blocks.shape)
        kept = (rows >= 0) & (columns >= 0)
        return sp.csc_matrix((blocks[kept], (rows[kept], columns[kept])), shape=(size, size))
