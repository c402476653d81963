"""One cell: choose, fit and predict on every fold of its split."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import State
from vtbench.run.choose import Prepared, Setting, choose, prepare
from vtbench.run.methods.base import Method
from vtbench.run.reduce import Reducer
from vtbench.tasks.base import Factor, Features, Feed, Split


@dataclass(frozen=True)
class Work:
    """All that a worker needs for one cell.

    Attributes:
        samples: name of the samples; cells with equal names share what is remembered of their blocks.
        blocks: block name -> features (n, columns), or (2 n, columns): as trained, then as tested.
        labels, ids: (n,).
        trained: name of what the training rows hold; cells with equal names, folds and methods choose alike.
        tested_from: row of `blocks` from which test rows are counted.
        missing: blocks that the test part lacks.
    """

    key: str
    method: Method
    feed: Feed
    split: Split
    samples: str
    blocks: Mapping[str, Features]
    labels: NDArray[np.int64]
    ids: NDArray[np.str_]
    n_classes: int
    seed: int
    timeout_s: float
    trained: str = ""
    tested_from: int = 0
    missing: tuple[str, ...] = ()

    def evaluate(self) -> Outcome:
        """Run the cell; see `evaluate`."""
        return evaluate(self)


@dataclass(frozen=True)
class Outcome:
    """What became of a cell; predictions where it went well, a one-line reason where not."""

    key: str
    state: State
    reason: str = ""
    predictions: Mapping[str, NDArray[Any]] | None = None
    fit_s: float | None = None
    predict_us: float | None = None
    batch: int | None = None
    started: float = 0.0
    finished: float = 0.0


_reducers: dict[tuple[str, str], Reducer] = {}
_settings: dict[str, Setting] = {}


def evaluate(work: Work) -> Outcome:
    """Run one cell; errors of the method pass through.

    Returns:
        an outcome with the arrays `sample_id`, `group`, `label` (predicted), `fold` and `choices` (JSON a fold), and
        `scores` (predictions, classes) float32, minus infinity for classes not trained, where the method gives them.
    """
    reducer = _reducer(work)
    labels, ids, groups, scores, fold_of, choices = [], [], [], [], [], []
    fit_s, predict_s, reduce_us = [], 0.0, []
    for number, fold in enumerate(work.split.folds):
        known = work.labels[fold.train]
        if work.feed.shuffle_labels:
            known = np.random.default_rng([work.seed, number]).permutation(known)
        inner = work.split.inner_groups
        apart = None if inner is None else inner[fold.train]
        setting = _setting(work, reducer, fold.train, known, apart)
        made = prepare(work.method, work.feed, reducer, setting, fold.train, fold.test + work.tested_from)
        lacking = _take_away(work, made, setting)
        start = time.perf_counter()
        made.classifier.fit(made.train, known, **({"groups": apart} if work.method.learns else {}))
        fitted = time.perf_counter()
        predicted = _labels(made.classifier.predict(made.test, **lacking), len(fold.test), work.n_classes)
        done = time.perf_counter()
        fit_s.append(fitted - start)
        predict_s += done - fitted
        reduce_us.append(made.reduce_us)
        labels.append(predicted)
        ids.append(work.ids[fold.test])
        groups.append(work.split.interval_groups[fold.test])
        fold_of.append(np.full(len(fold.test), number, np.int32))
        scores.append(_scores(made.classifier, made.test, work.n_classes, lacking))
        choices.append(json.dumps(setting.as_json(), sort_keys=True))
    predictions: dict[str, NDArray[Any]] = {
        "sample_id": np.concatenate(ids),
        "group": np.concatenate(groups),
        "fold": np.concatenate(fold_of),
        "label": np.concatenate(labels),
        "choices": np.array(choices),
    }
    if all(part is not None for part in scores):
        predictions["scores"] = np.concatenate([part for part in scores if part is not None])
    tested = len(predictions["label"])
    return Outcome(
        work.key,
        "ok",
        predictions=predictions,
        fit_s=float(np.mean(fit_s)),
        predict_us=predict_s / tested * 1e6 + float(np.mean(reduce_us)),
        batch=max(1, round(tested / len(work.split.folds))),
    )


def _setting(
    work: Work, reducer: Reducer, train: NDArray[np.int64], known: NDArray[np.int64], apart: Factor | None
) -> Setting:
    """The choice on a training part, made once for all variants that differ in their test part alone."""
    if not work.trained or work.feed.shuffle_labels:
        return choose(work.method, work.feed, reducer, train, known, apart, work.seed)
    about = (work.trained, work.method.id, work.method.identity(), work.feed, work.split.name, work.seed)
    name = hashlib.sha256(repr(about).encode() + train.tobytes()).hexdigest()
    if name not in _settings:
        _settings[name] = choose(work.method, work.feed, reducer, train, known, apart, work.seed)
    return _settings[name]


def _take_away(work: Work, made: Prepared, setting: Setting) -> dict[str, Any]:
    """Set what is missing to the training mean, and say what `predict` is told of it.

    Sparse coding with a weight for each modality gives it weight 0, and weight 1 to what is left where a choice had
    left that out; nets are told by name; any other method sees the training mean.
    """
    if not work.missing:
        return {}
    for name in work.missing:
        made.test[:, made.groups[name]] = 0.0
    if work.method.weighs_groups:
        left = {name: weight for name, weight in setting.weights.items() if name not in work.missing}
        if not any(left.values()):
            left = dict.fromkeys(left, 1.0)
        return {"weights": {**dict.fromkeys(work.missing, 0.0), **left}} if left else {}
    return {"missing": work.missing} if work.method.learns and len(work.missing) < len(work.feed.blocks) else {}


def _reducer(work: Work) -> Reducer:
    """The reducer of these samples: methods on the same folds share it. One set of samples is kept at a time."""
    name = (work.samples, work.method.preprocess)
    if name not in _reducers:
        for other in [kept for kept in _reducers if kept[0] != work.samples]:
            del _reducers[other]
        _reducers[name] = Reducer({}, work.method.preprocess)
    _reducers[name].blocks = {**_reducers[name].blocks, **work.blocks}
    return _reducers[name]


def _labels(predicted: Any, n: int, n_classes: int) -> NDArray[np.int32]:
    """Predictions as class indices.

    Raises:
        ValueError: wrong length, or something that is no class index.
    """
    values = np.asarray(predicted)
    if values.shape != (n,):
        raise ValueError(f"predict() gave shape {values.shape}, expected ({n},)")
    whole = values.dtype.kind in "iu" or (values.dtype.kind == "f" and bool(np.all(values == np.round(values))))
    if not whole or values.min() < 0 or values.max() >= n_classes:
        raise ValueError(f"predict() gave {values.dtype} values that are not class indices 0..{n_classes - 1}")
    return values.astype(np.int32)


def _scores(classifier: Any, x: NDArray[Any], n_classes: int, lacking: Mapping[str, Any]) -> NDArray[np.float32] | None:
    """(q, n_classes) scores by `decision_function` or `predict_proba`; None where the classifier has neither.

    Raises:
        ValueError: NaN among them.
    """
    for name in ("decision_function", "predict_proba"):
        score = getattr(classifier, name, None)
        known = getattr(classifier, "classes_", None)
        if score is None or known is None:
            continue
        values = np.asarray(score(x, **lacking), np.float32)
        if values.shape == (len(x), len(known)):
            if np.isnan(values).any():
                raise ValueError(f"{name}() gave NaN")
            wide = np.full((len(x), n_classes), -np.inf, np.float32)
            wide[:, np.asarray(known, np.int64)] = values
            return wide
    return None
