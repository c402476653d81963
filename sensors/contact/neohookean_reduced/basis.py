"""Proper orthogonal decomposition: the few displacement fields that span a set of snapshots."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_RELEVANT = 1e-10
"""Singular values below this share of the first are rounding."""


def pod_basis(snapshots: Floats, modes: int) -> Floats:
    """Orthonormal columns (dofs, at most `modes`) nearest to `snapshots` (count, dofs) in the mean square.

    Every snapshot counts alike, shallow or deep: each is scaled to unit length. Fewer columns come back where the
    snapshots span less. Raises ValueError when all of them are zero.
    Source: L. Sirovich, "Turbulence and the dynamics of coherent structures", Q. Appl. Math. 45 (1987).
    """
    if modes < 1:
        raise ValueError(f"a reduced basis needs at least one mode, got {modes}")
    lengths = np.linalg.norm(snapshots, axis=1)
    if not (lengths > 0).any():
        raise ValueError("a reduced basis needs a snapshot that is not at rest")
    scaled = snapshots[lengths > 0] / lengths[lengths > 0, None]
    _, values, rows = np.linalg.svd(scaled, full_matrices=False)
    kept = min(modes, int((values > _RELEVANT * values[0]).sum()))
    return np.ascontiguousarray(rows[:kept].T)
