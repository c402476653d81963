"""Nested dissection of a brick of nodes: the elimination order that keeps the sparse factors small."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_LEAF = 2
"""Blocks of at most this many nodes a side are not cut further."""


def nested_dissection(points: tuple[int, int, int]) -> NDArray[np.int64]:
    """Node indices of a (px, py, pz) brick in elimination order, (px py pz,).

    Each block is cut by a plane of nodes across its longest side, and the plane comes after its two halves.
    Source: A. George, "Nested dissection of a regular finite element mesh", SIAM J. Numer. Anal. 10 (1973).
    """
    pieces: list[NDArray[np.int64]] = []
    _dissect(np.arange(np.prod(points)).reshape(points), pieces)
    return np.concatenate(pieces)


def _dissect(block: NDArray[np.int64], pieces: list[NDArray[np.int64]]) -> None:
    if block.size == 0:
        return
    if max(block.shape) <= _LEAF:
        pieces.append(block.ravel())
        return
    axis = int(np.argmax(block.shape))
    middle = block.shape[axis] // 2
    before, plane, after = np.split(block, [middle, middle + 1], axis=axis)
    _dissect(before, pieces)
    _dissect(after, pieces)
    pieces.append(plane.ravel())
