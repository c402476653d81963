"""Squared distances of rows to stored rows, each from its own pair alone, so that a query that is one lies at 0."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fusion.onnx.builder import Graph, integers

CHUNK_VALUES = 2**16  # of differences a query holds at once


def squared_distances(g: Graph, x: str, rows: NDArray[np.float64]) -> str:
    """Squared Euclidean distances of x (N, d) to `rows` (n, d): (N, n), double."""
    n, d = rows.shape
    step = max(1, CHUNK_VALUES // n)
    total = ""
    for start in range(0, d, step):
        columns = slice(start, min(start + step, d))
        part = g.op("Unsqueeze", g.columns(x, columns, d), integers(2))
        difference = g.op("Sub", part, np.ascontiguousarray(rows[:, columns].T)[None])
        squared = g.sum(g.op("Mul", difference, difference), 1)
        total = g.op("Add", total, squared) if total else squared
    return total
