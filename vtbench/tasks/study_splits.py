"""Splits of the studies: halves of every object's presses on a sensor, and a few presses to learn from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vtbench.tasks.base import Fold, NotPossibleError, Split, SplitRule, TaskData
from vtbench.tasks.splits import guarded

DRAWS = 10


def pools(*factors: NDArray[Any]) -> NDArray[np.int64]:
    """Number (n,) of the combination of values that a sample has."""
    codes = np.stack([np.unique(values, return_inverse=True)[1].ravel() for values in factors], 1)
    return np.asarray(np.unique(codes, axis=0, return_inverse=True)[1], np.int64).ravel()


def half_of(data: TaskData) -> NDArray[np.int64]:
    """Half (n,), 0 or 1: the presses of an object on a sensor are dealt out in turn, in the order of the data."""
    half = np.zeros(len(data), np.int64)
    pool = _object_on_sensor(data)
    for number in np.unique(pool):
        members = np.flatnonzero(pool == number)
        half[members] = np.arange(len(members)) % 2
    return half


def halves(data: TaskData, seed: int) -> Split:
    """Learn from one half of every object's presses and test on the other, then the other way round.

    Every press is tested once, so an interval has as many groups as there are presses. No seed is used.
    """
    half = half_of(data)
    if not half.any():
        raise NotPossibleError("no object was pressed twice on one sensor")
    folds = tuple(Fold(f"half-{h}", np.flatnonzero(half != h), np.flatnonzero(half == h)) for h in (0, 1))
    return guarded(Split("random", folds, data.ids.astype(np.str_), "press"), data)


def few_within(presses: int, most: int) -> SplitRule:
    """Draws that learn from `presses` presses of each object on a sensor and test another one on that sensor.

    Test presses are the same whatever `presses` is, and fewer presses are always among the more.

    Args:
        presses: to learn from, each object.
        most: largest `presses` of the study; an object on a sensor with no more than that is left out.
    """

    def rule(data: TaskData, seed: int) -> Split:
        units = data.factors.get("unit", np.zeros(len(data), np.int64))
        folds = []
        for unit in np.unique(units):
            for draw in range(DRAWS):
                parts = _drawn(data, np.flatnonzero(units == unit), [seed, draw], most + 1)
                test = [part[most:][:1] for part in parts]
                folds.append(_fold(f"unit-{unit}-draw-{draw}", [part[:presses] for part in parts], test))
        return guarded(Split("random", tuple(folds), data.ids.astype(np.str_), "press"), data)

    return rule


def few_of_other_units(presses: int, most: int) -> SplitRule:
    """Draws that learn from `presses` presses of each object on the other sensors, and test a sensor whole."""

    def rule(data: TaskData, seed: int) -> Split:
        units = data.factor("unit")
        levels = np.unique(units)
        if len(levels) < 2:
            raise NotPossibleError(f"there is one unit only ({levels[0]}), so none can be held out")
        folds = []
        for unit in levels:
            test = np.flatnonzero(units == unit)
            for draw in range(DRAWS):
                parts = _drawn(data, np.flatnonzero(units != unit), [seed, draw], most)
                folds.append(_fold(f"unit-{unit}-draw-{draw}", [part[:presses] for part in parts], [test]))
        split = Split("held-out-unit", tuple(folds), units.astype(np.str_), "unit", inner_groups=units)
        return guarded(split, data, held_out=units)

    return rule


def _object_on_sensor(data: TaskData) -> NDArray[np.int64]:
    return pools(data.labels, *(data.factors[name] for name in ("unit", "press") if name in data.factors))


def _drawn(data: TaskData, rows: NDArray[np.int64], seed: Sequence[int], least: int) -> list[NDArray[np.int64]]:
    """The rows of each object in the order of a draw; NotPossibleError where an object has fewer than `least`."""
    parts = []
    for label in np.unique(data.labels):
        members = rows[data.labels[rows] == label]
        if len(members) < least:
            raise NotPossibleError(
                f"{data.classes[label]} was pressed {len(members)} times where {least} presses are needed"
            )
        parts.append(np.random.default_rng([*seed, int(label)]).permutation(members))
    return parts


def _fold(name: str, train: list[NDArray[np.int64]], test: list[NDArray[np.int64]]) -> Fold:
    return Fold(name, np.sort(np.concatenate(train)), np.sort(np.concatenate(test)))
