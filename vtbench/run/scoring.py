"""Predictions and truth -> metrics with intervals. Never runs a model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import Metric, Verdict
from leaderboard.statistics import group_interval, wilson

Arrays = Mapping[str, NDArray[Any]]

_LAW = {
    "perfect": "with all variation off every method scores 100 %",
    "chance": "frames without contact score chance",
}


def true_labels(predictions: Arrays, ids: NDArray[np.str_], labels: NDArray[np.int64]) -> NDArray[np.int64]:
    """Truth (predictions,) of each prediction, joined by sample id.

    Raises:
        ValueError: a prediction for a sample that the data do not hold.
    """
    order = np.argsort(ids)
    at = np.minimum(np.searchsorted(ids, predictions["sample_id"], sorter=order), len(ids) - 1)
    found = order[at]
    unknown = ids[found] != predictions["sample_id"]
    if unknown.any():
        raise ValueError(
            f"prediction for sample {str(predictions['sample_id'][unknown][0])!r}, which the data do not hold"
        )
    return labels[found]


def score(predictions: Arrays, truth: NDArray[np.int64], seed: int = 0) -> tuple[Metric, ...]:
    """Accuracy with its interval over groups, balanced accuracy, and accuracy fold by fold.

    Args:
        predictions: `label`, `group` and `fold`, each (predictions,).
        truth: (predictions,) class indices.
        seed: of the bootstrap.
    """
    correct = predictions["label"] == truth
    interval = group_interval(correct, predictions["group"], seed=seed)
    n, groups = len(correct), interval.groups
    folds = np.unique(predictions["fold"])
    by_fold = np.array([correct[predictions["fold"] == fold].mean() for fold in folds])
    by_class = np.array([correct[truth == label].mean() for label in np.unique(truth)])
    accuracy = Metric(
        name="accuracy",
        value=interval.value,
        n=n,
        groups=groups,
        low=interval.low,
        high=interval.high,
        interval=interval.method,
    )
    spread = {
        "balanced_accuracy": by_class.mean(),
        "worst_fold_accuracy": by_fold.min(),
        "best_fold_accuracy": by_fold.max(),
    }
    metrics = [accuracy, *(Metric(name=k, value=float(v), n=n, groups=groups) for k, v in spread.items())]
    if len(folds) > 1:
        sd = float(by_fold.std(ddof=1))
        metrics.append(Metric(name="fold_sd", value=sd, direction="lower", n=n, groups=len(folds)))
    return tuple(metrics)


def verdict(law: str, accuracy: Metric, n_classes: int) -> Verdict:
    """Whether an accuracy is what a law (`perfect` or `chance`) demands.

    Chance holds where 1 / classes lies inside the 99 % Wilson interval of as many independent trials as there are
    groups: a law is checked often, and one in twenty would fail by luck at 95 %.
    """
    if law == "perfect":
        passed, expected = accuracy.value == 1.0, "100.0 %"
    else:
        chance = 1 / n_classes
        low, high = wilson(accuracy.value * accuracy.groups, accuracy.groups, level=0.99)
        passed, expected = low <= chance <= high, f"{100 * chance:.1f} %"
    return Verdict(law=_LAW[law], expected=expected, observed=f"{100 * accuracy.value:.1f} %", passed=passed)
