"""One press as a potential: stored energy + contact, over the free displacements and, under a load, the indentation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from sensors.contact.neohookean.assembly import Assembly
from sensors.contact.neohookean.contact import TopContact

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Press:
    """The unknowns are the free displacements in the assembly's order, then the indentation.

    Depth control (`load_n` None) holds the indentation; load control gives it the work -F d.
    """

    assembly: Assembly
    contact: TopContact
    indentation_m: float
    load_n: float | None = None

    def pack(self, displacement: Floats) -> Floats:
        """The vector of unknowns for nodal displacements (n, 3)."""
        free = displacement.ravel()[self.assembly.order]
        return free if self.load_n is None else np.append(free, self.indentation_m)

    def unpack(self, at: Floats) -> tuple[Floats, float]:
        """Nodal displacements (n, 3) and indentation of a vector of unknowns."""
        displacement = np.zeros(self.assembly.mesh.nodes.size)
        free = len(self.assembly.order)
        displacement[self.assembly.order] = at[:free]
        return displacement.reshape(-1, 3), self.indentation_m if self.load_n is None else float(at[-1])

    def energy(self, at: Floats) -> float:
        """Total potential (J); infinite where an element is inside out."""
        displacement, indentation = self.unpack(at)
        stored = self.assembly.energy(displacement)
        if not np.isfinite(stored):
            return np.inf
        return stored + self.contact.energy(displacement, indentation) - (self.load_n or 0.0) * indentation

    def gradient(self, at: Floats) -> Floats:
        """Forces out of balance (N)."""
        displacement, indentation = self.unpack(at)
        force = self.assembly.force(displacement)
        top, total = self.contact.force(displacement, indentation)
        force[self.contact.mesh.top] += top
        free = force.ravel()[self.assembly.order]
        return free if self.load_n is None else np.append(free, total - self.load_n)

    def hessian(self, at: Floats) -> sp.csc_matrix:
        """Consistent tangent (N/m)."""
        displacement, indentation = self.unpack(at)
        whole = self.assembly.stiffness(displacement)
        whole = whole + self.contact.hessian(displacement, indentation, self.assembly.place)
        return whole[:-1, :-1] if self.load_n is None else whole
