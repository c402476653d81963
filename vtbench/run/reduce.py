"""Feature blocks of one training and one test part, cut to size, standardised and brought to one scale."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vtbench.tasks.base import Block, Features

Floats = NDArray[np.floating]
KEPT_BYTES = 192 * 2**20
"""Of reduced blocks in one process: a split's folds and inner folds for a few blocks fit."""


@dataclass(frozen=True)
class Reduced:
    """One block for a training part (n, columns) and a test part (q, columns), at its largest size.

    Attributes:
        us_per_sample: time that reducing a test sample took, microseconds.
    """

    train: Floats
    test: Floats
    us_per_sample: float

    @property
    def nbytes(self) -> int:
        """Memory of both parts."""
        return self.train.nbytes + self.test.nbytes


class Reducer:
    """Reduces blocks, and remembers them: every method on a fold, and every size, starts from the same fit.

    Args:
        blocks: block name -> features (samples, columns).
        mode: `scaled` standardises, reduces and brings a block to mean squared norm 1; `none` only cuts columns.
    """

    def __init__(self, blocks: Mapping[str, Features], mode: Literal["scaled", "none"]) -> None:
        self.blocks = blocks
        self.mode = mode
        self._kept: OrderedDict[tuple[str, bytes, bytes], Reduced] = OrderedDict()
        self._bytes = 0

    def at(self, block: Block, size: int | None, train: NDArray[np.int64], test: NDArray[np.int64]) -> Reduced:
        """Block at one of its sizes (None: all columns)."""
        if self.mode == "none" or block.leading:
            width = size if size is not None else self.blocks[block.name].shape[1]
            columns = self.blocks[block.name][:, :width]
            if self.mode == "none":
                return Reduced(columns[train], columns[test], 0.0)
            return _scaled(columns[train], columns[test], None)
        whole = self._whole(block, train, test)
        if size is None or size >= whole.train.shape[1]:
            return whole
        # principal components are nested: the first ones of a larger fit are those of a smaller one
        scale = unit_scale(whole.train[:, :size])
        return Reduced(whole.train[:, :size] * scale, whole.test[:, :size] * scale, whole.us_per_sample)

    def _whole(self, block: Block, train: NDArray[np.int64], test: NDArray[np.int64]) -> Reduced:
        key = (block.name, train.tobytes(), test.tobytes())
        if key not in self._kept:
            features = self.blocks[block.name]
            most = max(block.components, default=None)
            self._kept[key] = _scaled(features[train], features[test], most)
            self._bytes += self._kept[key].nbytes
            while self._bytes > KEPT_BYTES and len(self._kept) > 1:
                self._bytes -= self._kept.popitem(last=False)[1].nbytes
        self._kept.move_to_end(key)
        return self._kept[key]


def _scaled(train: Features, test: Features, n_components: int | None) -> Reduced:
    from fusion.features import ModalityPCA

    if n_components is not None:
        n_components = min(n_components, *train.shape)
    groups = {"all": slice(0, train.shape[1])}
    counts = None if n_components is None else {"all": n_components}
    transform = ModalityPCA(groups, counts).fit(train)
    reduced_train = np.asarray(transform.transform(train))
    start = time.perf_counter()
    reduced_test = np.asarray(transform.transform(test))
    return Reduced(reduced_train, reduced_test, (time.perf_counter() - start) / len(test) * 1e6)


def unit_scale(x: Floats) -> float:
    """Factor that brings rows to mean squared norm 1; 1 where all rows are zero."""
    energy = float(np.mean(np.sum(np.square(x, dtype=np.float64), axis=1)))
    return energy**-0.5 if energy > 0 else 1.0
