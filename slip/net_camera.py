"""The camera's part of a net: frames to a coarse grid, its change from frame to frame, a short embedding."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slip.net import KERNEL, HeldEmbedding, Net, compress, relu
from slip.samples import Floats
from slip.training_trial import Images


def edges(pixels: int, cells: int) -> NDArray[np.intp]:
    """Cut one side into `cells` runs of pixels whose lengths differ by at most 1; their ends (cells + 1,)."""
    if pixels < cells:
        raise ValueError(f"expected frames of at least {cells} x {cells} pixels, got a side of {pixels}")
    return np.arange(cells + 1) * pixels // cells


def downsample(frames: Images, grid: int) -> Floats:
    """Mean of each cell of a grid, in grey levels; (F, H, W, 3) uint8 -> (F, grid, grid, 3)."""
    _, height, width, _ = frames.shape
    rows, columns = edges(height, grid), edges(width, grid)
    small = np.empty((len(frames), grid, grid, 3))
    for i, frame in enumerate(frames):
        by_row = np.add.reduceat(frame, rows[:-1], axis=0, dtype=np.float64)
        np.add.reduceat(by_row, columns[:-1], axis=1, out=small[i])
    return small / (np.diff(rows)[:, None, None] * np.diff(columns)[None, :, None])


def changes(small: Floats) -> Floats:
    """Change of each downsampled frame from the one before it, 0 for the first; same shape."""
    change = np.zeros_like(small)
    np.subtract(small[1:], small[:-1], out=change[1:])
    return change


def patches(change: Floats, patch: int) -> Floats:
    """Cut (F, grid, grid, 3) into squares; (F, cells, patch x patch x 3)."""
    frames, grid, _, _ = change.shape
    side = grid // patch
    cut = change.reshape(frames, side, patch, side, patch, 3).transpose(0, 1, 3, 2, 4, 5)
    return cut.reshape(frames, side * side, patch * patch * 3)


def features(net: Net, change: Floats) -> Floats:
    """What one frame's change says, cell by cell; (F, grid, grid, 3) -> (F, cells x patch_features)."""
    seen = patches(compress(change / net.frame_scale), net.shape.patch)
    return relu(net.layer(seen, "patch")).reshape(len(change), -1)


def embeddings(net: Net, frames: Images) -> Floats:
    """Embed every frame with the two before it; (F, H, W, 3) uint8 -> (F, embedding)."""
    told = features(net, changes(downsample(frames, net.shape.grid)))
    padded = np.concatenate([np.zeros((KERNEL - 1, told.shape[1])), told])
    rows = [padded[tap : tap + len(told)] for tap in range(KERNEL)]
    return relu(net.layer(np.concatenate(rows, axis=1), "motion"))


class Camera(HeldEmbedding):
    """The running state of the camera's part."""

    def __init__(self, net: Net) -> None:
        super().__init__(net.shape.embedding)
        self._net = net
        self._small: Floats | None = None
        self._told = np.zeros((KERNEL, net.shape.cells * net.shape.patch_features))

    def push(self, frame: Images) -> None:
        """Take the next frame (H, W, 3); its embedding holds until another comes."""
        small = downsample(frame[None], self._net.shape.grid)
        change = np.zeros_like(small) if self._small is None else small - self._small
        self._small = small
        self._told[:-1] = self._told[1:]
        self._told[-1] = features(self._net, change)[0]
        self.embedding = relu(self._net.layer(self._told.reshape(-1), "motion"))
