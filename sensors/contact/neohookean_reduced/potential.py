"""Energy of a reduced press: stored energy of the sampled elements + contact, over the modes' amplitudes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from sensors.contact.neohookean.contact import TopContact
from sensors.contact.neohookean.material import NeoHookean, Strain, energy, internal_force, stiffness, strain
from sensors.contact.neohookean.mesh import PadMesh

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ReducedSolid:
    """`solid` on `mesh`, moving in the `basis` (3 nodes, modes) and summed over elements with `weights` (elements,)."""

    mesh: PadMesh
    solid: NeoHookean
    basis: Floats
    weights: Floats

    @cached_property
    def sampled(self) -> NDArray[np.int64]:
        """Elements with a weight."""
        return np.flatnonzero(self.weights > 0)

    @cached_property
    def _gradients(self) -> Floats:
        return self.mesh.gradients[self.sampled]

    @cached_property
    def _volumes(self) -> Floats:
        return self.mesh.weights[self.sampled] * self.weights[self.sampled, None]

    @cached_property
    def _modes(self) -> Floats:
        """The basis at the nodes of the sampled elements, (sampled, 24, modes)."""
        nodes = self.basis.reshape(-1, 3, self.basis.shape[1])[self.mesh.elements[self.sampled]]
        return np.ascontiguousarray(nodes.reshape(len(self.sampled), 24, -1))

    @cached_property
    def top_modes(self) -> Floats:
        """The basis at the top nodes, (3 top nodes, modes)."""
        nodes = self.basis.reshape(-1, 3, self.basis.shape[1])[self.mesh.top]
        return np.ascontiguousarray(nodes.reshape(-1, self.basis.shape[1]))

    def strain(self, amplitudes: Floats) -> Strain:
        """Deformation of the sampled elements."""
        nodal = (self._modes @ amplitudes).reshape(-1, 8, 3)
        return strain(self._gradients, self._volumes, nodal)

    def energy(self, state: Strain) -> float:
        """Stored energy (J); infinite where a sampled element is inside out."""
        return energy(self.solid, self._volumes, state)

    def force(self, state: Strain) -> Floats:
        """Its derivative by the amplitudes, (modes,)."""
        local = internal_force(self.solid, self._volumes, state)
        return np.tensordot(local, self._modes, 2)

    def stiffness(self, state: Strain) -> Floats:
        """Its second derivative, (modes, modes)."""
        local = stiffness(self.solid, self._gradients, self._volumes, state)
        flat = self._modes.reshape(-1, self._modes.shape[2])
        return flat.T @ (local @ self._modes).reshape(flat.shape)


@dataclass(frozen=True)
class ReducedPress:
    """The unknowns are the amplitudes, then, under a load, the indentation; see `Press` of the full model."""

    solid: ReducedSolid
    contact: TopContact
    indentation_m: float
    load_n: float | None = None

    def pack(self, amplitudes: Floats) -> Floats:
        """The vector of unknowns."""
        return amplitudes if self.load_n is None else np.append(amplitudes, self.indentation_m)

    def unpack(self, at: Floats) -> tuple[Floats, float]:
        """Amplitudes and indentation of a vector of unknowns."""
        return (at, self.indentation_m) if self.load_n is None else (at[:-1], float(at[-1]))

    def top(self, amplitudes: Floats) -> Floats:
        """Displacements (n, 3) of which only those of the top nodes are filled in."""
        out = np.zeros_like(self.solid.mesh.nodes)
        out[self.solid.mesh.top] = (self.solid.top_modes @ amplitudes).reshape(-1, 3)
        return out

    def energy(self, at: Floats) -> float:
        """Total potential (J); infinite where a sampled element is inside out."""
        amplitudes, depth = self.unpack(at)
        stored = self.solid.energy(self.solid.strain(amplitudes))
        if not np.isfinite(stored):
            return np.inf
        return stored + self.contact.energy(self.top(amplitudes), depth) - (self.load_n or 0.0) * depth

    def gradient(self, at: Floats) -> Floats:
        """Generalised forces out of balance (N)."""
        amplitudes, depth = self.unpack(at)
        nodal, total = self.contact.force(self.top(amplitudes), depth)
        out = self.solid.force(self.solid.strain(amplitudes)) + self.solid.top_modes.T @ nodal.ravel()
        return out if self.load_n is None else np.append(out, total - self.load_n)

    def hessian(self, at: Floats) -> sp.csc_matrix:
        """Consistent tangent (N/m), small and full."""
        amplitudes, depth = self.unpack(at)
        modes = self.solid.top_modes
        contact = self.contact.hessian(self.top(amplitudes), depth, self._place)
        stored = self.solid.stiffness(self.solid.strain(amplitudes))
        if self.load_n is None:
            return sp.csc_matrix(stored + modes.T @ (contact[:-1, :-1] @ modes))
        wide = np.zeros((modes.shape[0] + 1, modes.shape[1] + 1))
        wide[:-1, :-1], wide[-1, -1] = modes, 1.0
        whole = wide.T @ (contact @ wide)
        whole[:-1, :-1] += stored
        return sp.csc_matrix(whole)

    @cached_property
    def _place(self) -> NDArray[np.int64]:
        """Row of each degree of freedom of the top in the contact's Hessian."""
        place = np.full(self.solid.mesh.nodes.size, -1)
        top = (3 * self.solid.mesh.top[:, None] + np.arange(3)).ravel()
        place[top] = np.arange(len(top))
        return place
