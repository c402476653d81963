"""Rules that split samples into training and test parts, and the guard against leakage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vtbench.tasks.base import Factor, Fold, NotPossibleError, Split, SplitRule, TaskData


def random_draws(
    *,
    test_fraction: float,
    runs: int = 10,
    strata: Sequence[str] = (),
    within_first: str | None = None,
    group_kind: str = "press",
) -> SplitRule:
    """Stratified draws, each with its own test part, all from one seed.

    In every draw each class (times each value of the `strata` factors) gives `test_fraction` of its samples,
    one at least, to the test part. Draws are independent: they share samples, so an interval must
    group by sample, as `interval_groups` says.

    Args:
        test_fraction: 0.1 is the 9:1 of ten presses, 1/12 the 11:1 of twelve.
        runs: number of draws.
        strata: factors that are stratified by beside the class; one that the data do not have is left out.
        within_first: factor of which only the lowest value takes part (`unit`: the first unit alone).
        group_kind: what one sample is called.
    """

    def rule(data: TaskData, seed: int) -> Split:
        taking_part = np.ones(len(data), bool)
        if within_first is not None and within_first in data.factors:
            values = data.factors[within_first]
            taking_part = values == values.min()
        keys = [data.labels, *(data.factors[name] for name in strata if name in data.factors)]
        stratum = np.unique(
            np.stack([np.unique(k, return_inverse=True)[1] for k in keys], 1), axis=0, return_inverse=True
        )[1].ravel()
        members = [np.flatnonzero((stratum == s) & taking_part) for s in np.unique(stratum[taking_part])]
        members = [m for m in members if len(m) >= 2]
        if not members:
            raise NotPossibleError("no class has two samples to divide between training and test")
        folds = []
        for run in range(runs):
            rng = np.random.default_rng([seed, run])
            test = np.concatenate([rng.permutation(m)[: max(1, round(test_fraction * len(m)))] for m in members])
            in_test = np.zeros(len(data), bool)
            in_test[test] = True
            folds.append(Fold(f"run-{run}", np.flatnonzero(taking_part & ~in_test), np.flatnonzero(in_test)))
        return guarded(Split("random", tuple(folds), data.ids.astype(np.str_), group_kind), data)

    return rule


def held_out(factor: str, *, differs: Sequence[str] = ()) -> SplitRule:
    """Every value of a factor is the test part in turn, with a model trained on the other values.

    Args:
        factor: the condition held out; intervals count one value as one trial.
        differs: factors whose combined value in a test part may not occur in training (poses, for `hard`).
    """

    def rule(data: TaskData, seed: int) -> Split:
        values = data.factor(factor)
        levels = np.unique(values)
        if len(levels) < 2:
            raise NotPossibleError(f"there is one {factor} only ({levels[0]}), so none can be held out")
        folds = tuple(
            Fold(f"{factor}-{level}", np.flatnonzero(values != level), np.flatnonzero(values == level))
            for level in levels
        )
        split = Split(f"held-out-{factor}", folds, values.astype(np.str_), factor, inner_groups=values)
        return guarded(split, data, held_out=values, differs=[data.factor(name) for name in differs])

    return rule


def guarded(split: Split, data: TaskData, held_out: Factor | None = None, differs: Sequence[Factor] = ()) -> Split:
    """Return the split when no fold leaks.

    Raises:
        NotPossibleError: a fold is empty, holds one class only, shares samples or ids between its parts, trains on the
            condition it tests, or tests a combination of the `differs` factors that it trained on.
    """
    for fold in split.folds:
        where = f"split {split.name!r}, fold {fold.name!r}"
        if not len(fold.train) or not len(fold.test):
            raise NotPossibleError(f"{where}: empty training or test part")
        if len(np.unique(data.labels[fold.train])) < 2:
            raise NotPossibleError(f"{where}: training part holds one class only")
        if _common(data.ids, fold):
            raise NotPossibleError(f"{where}: a sample stands in both the training and the test part")
        if held_out is not None and _common(held_out, fold):
            raise NotPossibleError(f"{where}: the held-out condition occurs in training")
        if differs and _common(_joined(differs), fold):
            raise NotPossibleError(f"{where}: a condition that should be unseen occurs in training")
    return split


def _common(values: NDArray[np.generic], fold: Fold) -> bool:
    return len(np.intersect1d(values[fold.train], values[fold.test])) > 0


def _joined(factors: Sequence[Factor]) -> NDArray[np.str_]:
    """(n,) one text a sample, equal where all factors are equal."""
    return np.array(["|".join(map(repr, row)) for row in zip(*(f.tolist() for f in factors), strict=True)])
