"""Choices on training folds: sizes, parameters, then weights, by inner cross-validation; no test row is read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vtbench.run.methods.base import Classifier, Method
from vtbench.run.reduce import Floats, Reducer
from vtbench.tasks.base import Factor, Feed

WEIGHT_CHOICES = ((1.0, 1.0), (1.0, 0.25), (1.0, 0.5), (1.0, 2.0), (1.0, 4.0), (1.0, 0.0), (0.0, 1.0))
"""Weights of the first block and of every other, equal weights first; at the ends one side is left out."""
INNER_FOLDS = 3

Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Setting:
    """One point of the choices: columns and weight of each block, parameters of the classifier."""

    sizes: Mapping[str, int | None]
    weights: Mapping[str, float]
    params: Mapping[str, Any]

    def as_json(self) -> dict[str, Any]:
        """Plain values, for the prediction file."""
        return {"sizes": dict(self.sizes), "weights": dict(self.weights), "params": dict(self.params)}


@dataclass(frozen=True)
class Prepared:
    """A classifier, unfitted, what it is fitted on and tested with, and where each block stands in that."""

    classifier: Classifier
    train: Floats
    test: Floats
    reduce_us: float
    groups: Mapping[str, slice]


def choose(
    method: Method,
    feed: Feed,
    reducer: Reducer,
    train: Rows,
    labels: NDArray[np.int64],
    groups: Factor | None,
    seed: int,
) -> Setting:
    """Best setting by mean accuracy over folds inside a training part; ties go to the earlier candidate.

    Args:
        train: rows of the training part.
        labels: (len(train),) their labels.
        groups: (len(train),) condition that the inner folds hold out too, or None for stratified folds.
        seed: shuffles the stratified folds.
    """
    best = first_setting(method, feed)
    folds = inner_folds(labels, groups, seed)
    known: dict[str, float] = {}

    def accuracy(setting: Setting) -> float:
        name = repr(setting)
        if name not in known:
            known[name] = float(
                np.mean([_fold_accuracy(method, feed, reducer, setting, train, labels, *fold) for fold in folds])
            )
        return known[name]

    with _quick_checks(method):
        for candidates in (_sizes, _params, _weights):
            tried = candidates(method, feed, best)
            if len(tried) > 1:
                best = max(tried, key=accuracy)
    return best


@contextmanager
def _quick_checks(method: Method) -> Iterator[None]:
    """Leave out scikit-learn's checks of parameters that are ours and of columns that have been checked already."""
    from sklearn import config_context

    ours = "estimator" not in method.source
    with config_context(assume_finite=ours, skip_parameter_validation=ours):
        yield


def first_setting(method: Method, feed: Feed) -> Setting:
    """Where the search starts: middle sizes, default parameters, equal weights."""
    return Setting(
        {block.name: block.sizes[len(block.sizes) // 2] if block.sizes else None for block in feed.blocks},
        {block.name: 1.0 for block in feed.blocks},
        {name: values[0] for name, values in method.choices.items()},
    )


def prepare(method: Method, feed: Feed, reducer: Reducer, setting: Setting, train: Rows, test: Rows) -> Prepared:
    """Columns and classifier of one setting; everything fitted on the rows `train`."""
    parts = [reducer.at(block, setting.sizes[block.name], train, test) for block in feed.blocks]
    stops = np.cumsum([part.train.shape[1] for part in parts]).tolist()
    groups = {
        block.name: slice(stop - part.train.shape[1], stop)
        for block, part, stop in zip(feed.blocks, parts, stops, strict=True)
    }
    scales = [1.0 if method.weighs_groups else setting.weights[block.name] for block in feed.blocks]
    return Prepared(
        method.build(groups, setting.weights, within(setting.params, len(train))),
        np.hstack([part.train * scale for part, scale in zip(parts, scales, strict=True)]),
        np.hstack([part.test * scale for part, scale in zip(parts, scales, strict=True)]),
        sum(part.us_per_sample for part in parts),
        groups,
    )


def within(params: Mapping[str, Any], n: int) -> dict[str, Any]:
    """Parameters with no more neighbours than the `n` training samples."""
    most = {"n_neighbors": min(params["n_neighbors"], n)} if "n_neighbors" in params else {}
    return {**params, **most}


def inner_folds(labels: NDArray[np.int64], groups: Factor | None, seed: int) -> list[tuple[Rows, Rows]]:
    """Positions (train, validation) of up to three folds inside a training part.

    With groups whole groups are held out; without, or where there is one group only, every class is dealt out evenly.
    """
    levels = np.unique(groups) if groups is not None else np.empty(0)
    if groups is not None and len(levels) >= 2:
        fold_of = np.searchsorted(levels, groups) % INNER_FOLDS
    else:
        rng = np.random.default_rng([seed, len(labels)])
        fold_of = np.empty(len(labels), np.int64)
        dealt = 0
        for label in np.unique(labels):
            members = rng.permutation(np.flatnonzero(labels == label))
            fold_of[members] = (np.arange(len(members)) + dealt) % INNER_FOLDS
            dealt += len(members)
    pairs = [(np.flatnonzero(fold_of != fold), np.flatnonzero(fold_of == fold)) for fold in np.unique(fold_of)]
    return [(train, held) for train, held in pairs if len(np.unique(labels[train])) > 1]


def _fold_accuracy(
    method: Method,
    feed: Feed,
    reducer: Reducer,
    setting: Setting,
    rows: Rows,
    labels: NDArray[np.int64],
    train: Rows,
    held: Rows,
) -> float:
    made = prepare(method, feed, reducer, setting, rows[train], rows[held])
    made.classifier.fit(made.train, labels[train])
    return float(np.mean(made.classifier.predict(made.test) == labels[held]))


def _sizes(method: Method, feed: Feed, best: Setting) -> list[Setting]:
    sized = [block for block in feed.blocks if block.sizes]
    return [
        replace(best, sizes={**best.sizes, **dict(zip([b.name for b in sized], sizes, strict=True))})
        for sizes in product(*(block.sizes for block in sized))
    ]


def _params(method: Method, feed: Feed, best: Setting) -> list[Setting]:
    return [
        replace(best, params=dict(zip(method.choices, values, strict=True)))
        for values in product(*method.choices.values())
    ]


def _weights(method: Method, feed: Feed, best: Setting) -> list[Setting]:
    if feed.weights == "equal" or method.learns:
        return [best]
    first, *others = [block.name for block in feed.blocks]
    return [replace(best, weights={first: a, **dict.fromkeys(others, b)}) for a, b in WEIGHT_CHOICES]
