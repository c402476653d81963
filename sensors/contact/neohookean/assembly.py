"""Sums over elements: energy, forces and sparse stiffness of a hyperelastic mesh."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from sensors.contact.neohookean.material import NeoHookean, Strain, energy, internal_force, stiffness, strain
from sensors.contact.neohookean.mesh import HexMesh

Floats = NDArray[np.float64]

_BLOCK = 1024
"""Elements worked on at a time, so that their arrays stay in the cache."""


class Assembly:
    """Energy, forces and stiffness of `solid` on `mesh`, for displacements (n, 3) in metres.

    `order` lists the degrees of freedom (3 node + direction) that rows and columns of the stiffness stand for; the
    others are held. One empty row and column at the end keep a place for the indentation.
    """

    def __init__(self, mesh: HexMesh, solid: NeoHookean, order: NDArray[np.int64]) -> None:
        self.mesh = mesh
        self.solid = solid
        self.order = order
        dofs = (3 * mesh.elements[:, :, None] + np.arange(3)).reshape(len(mesh.elements), 24)
        self._dofs = dofs
        place = np.full(mesh.nodes.size, -1)
        place[order] = np.arange(len(order))
        self.place = place
        self._pattern(place[dofs])

    def _pattern(self, local: NDArray[np.int64]) -> None:
        """Where each entry of the element matrices lands in the compressed columns."""
        size = len(self.order) + 1
        rows = np.broadcast_to(local[:, :, None], (len(local), 24, 24))
        columns = np.broadcast_to(local[:, None, :], rows.shape)
        kept = (rows >= 0) & (columns >= 0)
        keys = np.where(kept, columns * size + rows, -1).ravel()
        unique, inverse = np.unique(keys, return_inverse=True)
        self._skip = int(unique[0] == -1)
        self._entry = inverse
        unique = unique[self._skip :]
        self._rows = (unique % size).astype(np.int32)
        counts = np.bincount(unique // size, minlength=size)
        self._starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)

    def _blocks(self, displacement: Floats) -> Iterator[tuple[slice, Floats, Strain]]:
        for start in range(0, len(self.mesh.elements), _BLOCK):
            part = slice(start, start + _BLOCK)
            weights = self.mesh.weights[part]
            nodal = displacement[self.mesh.elements[part]]
            yield part, weights, strain(self.mesh.gradients[part], weights, nodal)

    def energy(self, displacement: Floats) -> float:
        """Stored energy (J); infinite where an element is inside out."""
        return sum(energy(self.solid, weights, state) for _, weights, state in self._blocks(displacement))

    def force(self, displacement: Floats) -> Floats:
        """Internal nodal forces (N), (n, 3): derivative of `energy`."""
        local = [internal_force(self.solid, weights, state) for _, weights, state in self._blocks(displacement)]
        total = np.bincount(self._dofs.ravel(), np.concatenate(local).ravel())
        return np.asarray(total, np.float64).reshape(-1, 3)

    def stiffness(self, displacement: Floats) -> sp.csc_matrix:
        """Consistent tangent (N/m) over `order`, plus the empty row and column of the indentation."""
        size = len(self.order) + 1
        local = np.empty((len(self.mesh.elements), 24, 24))
        for part, weights, state in self._blocks(displacement):
            local[part] = stiffness(self.solid, self.mesh.gradients[part], weights, state)
        data = np.bincount(self._entry, local.ravel())
        return sp.csc_matrix((data[self._skip :], self._rows, self._starts), shape=(size, size))

    def dilatation(self, displacement: Floats) -> Floats:
        """Mean volume ratio J of each element, (m,)."""
        return np.concatenate([state.dilatation for _, _, state in self._blocks(displacement)])
