"""Kernel sparse coding and its joint form: orthogonal matching pursuit unrolled, k steps without a loop.

As `fusion.pursuit` does it: an orthonormal direction a step, kept as its inner products with all atoms, and beside it
the row of the inverse Cholesky factor that turns projections into coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fusion.komp import pivot_tolerances
from fusion.onnx.builder import Graph, integers
from fusion.onnx.ends import between_two
from fusion.onnx.kernels import GraphKernel, kernel_rows
from fusion.pursuit import DOUBTFUL_PIVOT, EPS

MASK_STEP = 1.0  # as in fusion.class_residual


@dataclass(frozen=True)
class Codes:
    """Codes of one coupled group of modalities: atoms and whether they are used (N, k), coefficients (N, k) each."""

    atoms: str
    used: str
    coefs: list[str]


def sparse_coding(g: Graph, estimator: Any, x: str) -> str:
    """`fusion.KSC` and `fusion.JKSC`: minus the class residuals; of two classes minus and plus half of the decision."""
    if estimator.solver != "komp":
        raise ValueError(
            f"sparse coding with solver={estimator.solver!r} has no graph of fixed size; use solver='komp'"
        )
    if estimator.kernel not in ("rbf", "linear"):
        raise ValueError(f"sparse coding with kernel={estimator.kernel!r} has no graph; use kernel='rbf' or 'linear'")
    given = estimator._weights if hasattr(estimator, "_weights") else estimator._fitted_weights()
    weights = {name: weight for name, weight in given.items() if weight > 0}
    names = [name for name in estimator._modalities if name in weights]
    width = estimator.n_features_in_
    parts = [g.columns(x, estimator._columns[name], width) for name in names]
    kernels = [GraphKernel.of(g, estimator._modalities[name]) for name in names]
    values = kernel_rows(g, kernels, parts)
    n_classes = len(estimator.classes_)
    residual, found = "", ""
    for members in estimator._coupled(len(names)):
        group, rows = [kernels[i] for i in members], [values[i] for i in members]
        shares = [weights[names[i]] for i in members]
        codes = pursue(g, group, rows, shares, estimator.n_nonzero_coefs, estimator.pivot_tol)
        part, seen = _class_residual(g, group, rows, codes, estimator._atom_class, n_classes, shares)
        residual = g.op("Add", residual, part) if residual else part
        found = g.op("Or", found, seen) if found else seen
    scores = _class_scores(g, residual, found)
    return between_two(g, scores) if n_classes == 2 else scores


def pursue(
    g: Graph, kernels: list[GraphKernel], rows: list[str], weights: list[float], n_nonzero_coefs: int, pivot_tol: Any
) -> Codes:
    """Codes of all queries; `rows` are the modalities' kernel values (N, n) of queries with atoms."""
    n = kernels[0].n_atoms
    k = min(n_nonzero_coefs, n)
    tolerances = pivot_tolerances(pivot_tol, k)
    scales = [np.sqrt(weight) * kernel.selection for kernel, weight in zip(kernels, weights, strict=True)]
    tracks = [_Track(kernel, row) for kernel, row in zip(kernels, rows, strict=True)]
    free = g.op("Add", g.op("Mul", rows[0], 0.0), 1.0)
    alive = first = ""
    atoms, used = [], []
    for step in range(k):
        score = g.op("Mul", _size(g, [t.correlation for t in tracks], scales), free)
        atom = g.op("ArgMax", score, axis=1, keepdims=1)
        best = g.op("ReduceMax", score, integers(1), keepdims=1)
        first = first or best
        going = g.every(g.op("Greater", best, g.op("Mul", first, 8.0 * EPS)), g.op("Greater", best, 0.0))
        alive = g.op("And", alive, going) if alive else going
        usable = [track.step(g, step, k, atom, alive, float(tolerances[step])) for track in tracks]
        independent = usable[0]
        for other in usable[1:]:
            independent = g.op("Or", independent, other)
        alive = g.op("And", alive, independent)
        atoms.append(atom)
        used.append(alive)
        if step + 1 < k:
            free = g.op("ScatterElements", free, atom, g.op("Mul", best, 0.0), axis=1)
    return Codes(_side_by_side(g, atoms), _side_by_side(g, used), [track.coefs for track in tracks])


class _Track:
    """One modality's factorisation while the pursuit goes on; tensors by name."""

    def __init__(self, kernel: GraphKernel, correlation: str) -> None:
        self.kernel = kernel
        self.correlation = correlation  # (N, n) of the atoms with what is left of the query
        self.basis = ""  # (N, steps, n)
        self.inverse = ""  # (N, steps, k), rows of the inverse Cholesky factor
        self.norms = ""  # (N, 1, k) norms of the chosen atoms
        self.smallest = ""  # (N, 1) smallest pivot so far, as a part of its atom's squared norm
        self.coefs = ""  # (N, k)

    def step(self, g: Graph, step: int, k: int, atom: str, alive: str, tol: float) -> str:
        """Add one atom (N, 1); returns whether it is independent of the earlier ones here: (N, 1)."""
        unit = np.zeros((1, 1, k))
        unit[0, 0, step] = 1.0
        diagonal = g.op("Gather", self.kernel.diagonal, atom, axis=0)
        pivot, factors, w = diagonal, "", ""
        if step:
            place = g.op("Tile", g.op("Unsqueeze", atom, integers(2)), integers(1, step, 1))
            factors = g.op("Transpose", g.op("GatherElements", self.basis, place, axis=2), perm=[0, 2, 1])
            pivot = g.op("Sub", diagonal, g.sum(g.op("Mul", factors, factors), 2))
            w = g.op("MatMul", factors, self.inverse)
        usable = self._usable(g, pivot, diagonal, w, alive, tol)
        root = g.op("Sqrt", g.op("Where", usable, pivot, 1.0))
        scale = g.op("Where", usable, g.op("Div", 1.0, root), 0.0)
        projection = g.op("Mul", g.op("GatherElements", self.correlation, atom, axis=1), scale)
        wide_scale = g.op("Unsqueeze", scale, integers(2))
        direction = g.op("Mul", g.op("Sub", unit, w) if w else unit, wide_scale)
        share = g.op("Mul", g.op("Squeeze", direction, integers(1)), projection)
        self.coefs = g.op("Add", self.coefs, share) if self.coefs else share
        if step + 1 == k:
            return usable
        row = g.op("Unsqueeze", self.kernel.gram_rows(g, atom), integers(1))
        if step:
            row = g.op("Sub", row, g.op("MatMul", factors, self.basis))
        row = g.op("Mul", row, wide_scale)
        moved = g.op("Mul", g.op("Squeeze", row, integers(1)), projection)
        self.correlation = g.op("Sub", self.correlation, moved)
        norm = g.op("Mul", g.op("Unsqueeze", g.op("Sqrt", diagonal), integers(2)), unit)
        self.norms = g.op("Add", self.norms, norm) if self.norms else norm
        self.basis = g.op("Concat", self.basis, row, axis=1) if self.basis else row
        self.inverse = g.op("Concat", self.inverse, direction, axis=1) if self.inverse else direction
        return usable

    def _usable(self, g: Graph, pivot: str, diagonal: str, w: str, alive: str, tol: float) -> str:
        """Whether the pivot is above its rounding error, estimated where it is small."""
        large = g.op("Greater", pivot, g.op("Mul", diagonal, tol))
        usable = g.every(alive, g.op("Greater", diagonal, 0.0), large)
        part = g.op("Where", usable, g.op("Div", pivot, g.op("Where", usable, diagonal, 1.0)), 1.0)
        self.smallest = g.op("Min", self.smallest, part) if self.smallest else part
        if not w:
            return usable
        others = g.sum(g.op("Mul", g.op("Abs", w), self.norms), 2)
        size = g.op("Add", g.op("Sqrt", g.op("Max", diagonal, 0.0)), others)
        noise = g.op("Mul", g.op("Mul", size, size), 8.0 * EPS)
        trusted = g.op("GreaterOrEqual", self.smallest, DOUBTFUL_PIVOT)
        return g.op("And", usable, g.op("Or", trusted, g.op("Greater", pivot, noise)))


def _size(g: Graph, correlations: list[str], scales: list[Any]) -> str:
    """Size of each atom's correlation over the modalities: (N, n)."""
    sizes = [
        g.op("Mul", g.op("Abs", correlation), scale[None])
        for correlation, scale in zip(correlations, scales, strict=True)
    ]
    if len(sizes) == 1:
        return sizes[0]
    total = g.op("Mul", sizes[0], sizes[0])
    for size in sizes[1:]:
        total = g.op("Add", total, g.op("Mul", size, size))
    return g.op("Sqrt", total)


def _side_by_side(g: Graph, columns: list[str]) -> str:
    return columns[0] if len(columns) == 1 else g.op("Concat", *columns, axis=1)


def _class_residual(
    g: Graph,
    kernels: list[GraphKernel],
    rows: list[str],
    codes: Codes,
    atom_class: Any,
    n_classes: int,
    weights: list[float],
) -> tuple[str, str]:
    """Residuals (N, n_classes) and which classes hold a used atom, as `fusion.class_residual`."""
    mine = g.op("Gather", np.asarray(atom_class, np.int64), codes.atoms, axis=0)
    same = g.double(g.op("Equal", g.op("Unsqueeze", mine, integers(2)), g.op("Unsqueeze", mine, integers(1))))
    used = g.op("Unsqueeze", g.double(codes.used), integers(2))
    classes = g.op("Mul", g.op("Gather", np.eye(n_classes), mine, axis=0), used)  # (N, k, n_classes)
    total = ""
    for kernel, row, x, weight in zip(kernels, rows, codes.coefs, weights, strict=True):
        between = g.op("Mul", kernel.gram_between(g, codes.atoms), same)
        rebuilt = g.op("Squeeze", g.op("MatMul", between, g.op("Unsqueeze", x, integers(2))), integers(2))
        own = g.op("GatherElements", row, codes.atoms, axis=1)
        part = g.op("Mul", g.op("Mul", x, weight), g.op("Sub", rebuilt, g.op("Mul", own, 2.0)))
        total = g.op("Add", total, part) if total else part
    residual = g.sum(g.op("Mul", classes, g.op("Unsqueeze", total, integers(2))), 1)
    found = g.op("Greater", g.op("ReduceMax", classes, integers(1), keepdims=0), 0.0)
    return residual, found


def _class_scores(g: Graph, residual: str, found: str) -> str:
    """Minus the residual, finitely lower for classes without an atom, as `fusion.class_residual.class_scores`."""
    scores = g.op("Where", found, g.op("Neg", residual), 0.0)
    reach = g.op("Add", g.op("ReduceMax", g.op("Abs", scores), integers(1), keepdims=1), MASK_STEP)
    largest = float(np.finfo(np.float64).max)
    lowest = g.op("ReduceMin", g.op("Where", found, scores, largest), integers(1), keepdims=1)
    lowest = g.op("Where", g.op("Less", lowest, largest), lowest, reach)
    return g.op("Where", found, scores, g.op("Sub", lowest, reach))
