"""Grids of one pad, each with twice the cells of a side of the one before."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sensors.contact.operator import Compliance
from sensors.contact.solver import NO_SURFACE

Floats = NDArray[np.floating]


def check_levels(levels: Sequence[Compliance]) -> None:
    """ValueError where the cells of a side do not double from each level to the next."""
    sizes = [level.grid.n for level in levels]
    if not levels or any(fine != 2 * coarse for coarse, fine in pairwise(sizes)):
        raise ValueError(f"nested grids must double from the coarsest to the finest, got {sizes}")


def coarsened(gap: Floats) -> Floats:
    """Mean gap of each two by two cells that hold a surface; none where none does."""
    n = gap.shape[0] // 2
    blocks = gap.reshape(n, 2, n, 2)
    there = np.isfinite(blocks)
    count = there.sum(axis=(1, 3))
    total = np.where(there, blocks, 0).sum(axis=(1, 3))
    return np.where(count > 0, total / np.maximum(count, 1), NO_SURFACE)
