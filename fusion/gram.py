"""The Gram matrices of a dictionary, stored or as the recipe for their rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.arrays import FloatArray, IntArray, frozen

LINEAR = -1.0  # in the place of a kernel's width


class Gram(NamedTuple):
    """Gram matrices of n atoms in M modalities; what is not stored is computed from the atoms, row by row."""

    stored: FloatArray  # (M, n, n), or (0, 0, 0): on demand
    diagonals: FloatArray  # (M, n)
    atoms: FloatArray  # (sum of columns, n), one modality below the other; (0, 0) where stored
    bounds: IntArray  # (M + 1,), rows of `atoms` that belong to modality m: bounds[m] to bounds[m + 1]
    widths: FloatArray  # (M,), gamma of an RBF kernel or LINEAR
    factors: FloatArray  # (M, n), what a value is multiplied by on each side

    @property
    def n_modalities(self) -> int:
        """M."""
        return len(self.diagonals)

    @property
    def n_atoms(self) -> int:
        """n."""
        return self.diagonals.shape[1]

    def part(self, members: Sequence[int]) -> Gram:
        """The modalities `members`; without copying a stored matrix where they are all, or one."""
        if list(members) == list(range(self.n_modalities)):
            return self
        chosen = slice(members[0], members[0] + 1) if len(members) == 1 else list(members)
        pieces = [self.atoms[self.bounds[m] : self.bounds[m + 1]] for m in members]
        return _gram(
            self.stored[chosen] if len(self.stored) else self.stored,
            self.diagonals[chosen],
            np.concatenate(pieces),
            np.cumsum([0, *map(len, pieces)]),
            self.widths[chosen],
            self.factors[chosen],
        )


def stored_gram(matrices: FloatArray | Sequence[FloatArray]) -> Gram:
    """Gram matrices (M, n, n) as they are; a sequence of M matrices (n, n) is copied unless it holds one."""
    stack = frozen(matrices[0])[None] if len(matrices) == 1 else frozen(matrices)
    m, n = stack.shape[:2]
    diagonals = np.diagonal(stack, axis1=1, axis2=2)
    return _gram(stack, diagonals, np.empty((0, 0)), np.zeros(m + 1), np.zeros(m), np.ones((m, n)))


def gram_on_demand(
    atoms: Sequence[FloatArray], widths: Sequence[float], factors: Sequence[FloatArray], own: Sequence[FloatArray]
) -> Gram:
    """Rows from the atoms: M arrays (columns, n), widths, factors (n,) and kernel values of the atoms (n,)."""
    bounds = np.cumsum([0, *map(len, atoms)])
    return _gram(np.empty((0, 0, 0)), np.stack(own), np.concatenate(atoms), bounds, np.array(widths), np.stack(factors))


def _gram(
    stored: FloatArray,
    diagonals: FloatArray,
    atoms: FloatArray,
    bounds: NDArray[Any],
    widths: FloatArray,
    factors: FloatArray,
) -> Gram:
    return Gram(
        frozen(stored), frozen(diagonals), frozen(atoms), frozen(bounds, np.int64), frozen(widths), frozen(factors)
    )
