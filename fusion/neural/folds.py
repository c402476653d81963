"""Folds held back inside a training part, to choose when to stop."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.int64]


def held_back_folds(
    target: Rows, groups: NDArray[Any] | None, n_folds: int, rng: np.random.Generator
) -> list[tuple[Rows, Rows]]:
    """Rows (learnt from, held back) of up to `n_folds` folds; none where the rows allow none.

    With two groups or more whole groups are held back; else every class is dealt out evenly. A fold counts only if
    every class that it holds back is learnt from, and at least two are.
    """
    levels = np.unique(groups) if groups is not None else np.empty(0)
    fold_of = np.empty(len(target), np.int64)
    if groups is not None and len(levels) >= 2:
        fold_of[:] = np.searchsorted(levels, groups) % n_folds
    else:
        dealt = 0
        for label in np.unique(target):
            members = rng.permutation(np.flatnonzero(target == label))
            fold_of[members] = (np.arange(len(members)) + dealt) % n_folds
            dealt += len(members)
    pairs = [(np.flatnonzero(fold_of != fold), np.flatnonzero(fold_of == fold)) for fold in np.unique(fold_of)]
    return [
        (learnt, held)
        for learnt, held in pairs
        if len(np.unique(target[learnt])) > 1 and not len(np.setdiff1d(target[held], target[learnt]))
    ]
