"""A modality's kernel in a graph: rows of queries, and the Gram matrix, stored or computed from the atoms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.onnx.builder import Graph, integers
from fusion.onnx.distances import squared_distances

STORED_ATOMS = 2048  # a Gram matrix of as many takes 34 MB; above, its rows are computed from the atoms

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GraphKernel:
    """RBF or linear kernel with its atoms.

    Attributes:
        gamma: of an RBF kernel; None is linear.
        atoms: (n, d).
        factor: (n,) on values of each atom, its inverse norm where a linear kernel is normalised, else 1.
        normalize: whether a query's own norm is divided by, too.
        diagonal: (n,) kernel values of the atoms with themselves.
        stored: Gram matrix (n, n), or None.
    """

    gamma: float | None
    atoms: Floats
    factor: Floats
    normalize: bool
    diagonal: Floats
    stored: Floats | None

    @classmethod
    def of(cls, g: Graph, modality: Any) -> GraphKernel:
        """From a fitted `fusion.modality.Modality`, whose atoms are (d, n)."""
        atoms = np.ascontiguousarray(modality.atoms.T)
        diagonal = np.asarray(modality.diagonal(), np.float64)
        rbf = modality.kernel == "rbf"
        cosine = modality.normalize and not rbf
        factor = np.where(diagonal > 0, 1.0 / np.sqrt(np.where(diagonal > 0, modality.self_values, 1.0)), 0.0)
        return cls(
            float(modality.gamma) if rbf else None,
            atoms,
            factor if cosine else np.ones(len(atoms)),
            cosine,
            diagonal,
            np.asarray(modality.gram()) if len(atoms) <= STORED_ATOMS else None,
        )

    @property
    def n_atoms(self) -> int:
        """n."""
        return len(self.atoms)

    @property
    def selection(self) -> Floats:
        """Factor on each atom's correlation, (n,); 0 bars the atom."""
        usable = self.diagonal > 0
        return np.where(usable, 1.0 / np.sqrt(np.where(usable, self.diagonal, 1.0)), 0.0)

    def exponents(self, g: Graph, x: str) -> str:
        """gamma times the squared distances of x (N, d) to the atoms: (N, n)."""
        assert self.gamma is not None
        return g.op("Mul", squared_distances(g, x, self.atoms), self.gamma)

    def products(self, g: Graph, x: str) -> str:
        """Linear kernel values of x (N, d) with the atoms: (N, n)."""
        values = g.op("Mul", g.times(x, self.atoms.T), self.factor[None])
        if not self.normalize:
            return values
        own = g.sum(g.op("Mul", x, x), 1, keep=True)
        positive = g.op("Greater", own, 0.0)
        root = g.op("Sqrt", g.op("Where", positive, own, 1.0))
        return g.op("Where", positive, g.op("Div", values, root), 0.0)

    def gram_rows(self, g: Graph, atom: str) -> str:
        """Rows (N, n) of the Gram matrix, of atoms (N, 1)."""
        place = g.op("Squeeze", atom, integers(1))
        if self.stored is not None:
            return g.op("Gather", self.stored, place, axis=0)
        chosen = g.op("Gather", self.atoms, place, axis=0)
        return (
            g.op("Exp", g.op("Neg", self.exponents(g, chosen))) if self.gamma is not None else self.products(g, chosen)
        )

    def gram_between(self, g: Graph, atoms: str) -> str:
        """Values (N, k, k) of the Gram matrix between atoms (N, k)."""
        if self.stored is not None:
            start = g.op("Mul", g.op("Unsqueeze", atoms, integers(2)), integers(self.n_atoms))
            place = g.op("Add", start, g.op("Unsqueeze", atoms, integers(1)))
            return g.op("Gather", g.op("Reshape", self.stored, integers(-1)), place, axis=0)
        chosen = g.op("Gather", self.atoms, atoms, axis=0)  # (N, k, d)
        if self.gamma is None:
            scaled = g.op("Mul", chosen, g.op("Gather", self.factor[:, None], atoms, axis=0))
            return g.op("MatMul", scaled, g.op("Transpose", scaled, perm=[0, 2, 1]))
        apart = g.op("Sub", g.op("Unsqueeze", chosen, integers(2)), g.op("Unsqueeze", chosen, integers(1)))
        return g.op("Exp", g.op("Mul", g.sum(g.op("Mul", apart, apart), 3), -self.gamma))


def kernel_rows(g: Graph, kernels: list[GraphKernel], queries: list[str]) -> list[str]:
    """Kernel values (N, n) of queries (N, d) in each modality; RBF rows shifted as `fusion.modality.kernel_rows`."""
    if kernels[0].gamma is None:
        return [kernel.products(g, query) for kernel, query in zip(kernels, queries, strict=True)]
    exponents = [kernel.exponents(g, query) for kernel, query in zip(kernels, queries, strict=True)]
    nearest = [g.op("ReduceMin", each, integers(1), keepdims=1) for each in exponents]
    shift = nearest[0] if len(nearest) == 1 else g.op("Min", *nearest)
    return [g.op("Exp", g.op("Sub", shift, each)) for each in exponents]
