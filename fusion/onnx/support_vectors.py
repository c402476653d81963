"""Support vector classifiers with an RBF or linear kernel, one against one as libsvm decides."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.onnx.builder import Graph, integers
from fusion.onnx.distances import squared_distances
from fusion.onnx.ends import halves

VOTE_SHARE = 3.0  # scikit-learn keeps a class's summed margins below one third of a vote


def support_vectors(g: Graph, estimator: Any, x: str) -> str:
    """scikit-learn's `SVC`.

    Scores are `decision_function` (one against the rest: votes and bounded margins), in which the class that `predict`
    answers is raised to the largest score where a tie of votes gave it to another; of two classes, minus and plus half.
    """
    if estimator.kernel not in ("rbf", "linear"):
        raise ValueError(f"SVC with kernel={estimator.kernel!r} is not exported; use 'rbf' or 'linear'")
    vectors = np.asarray(estimator.support_vectors_, np.float64)
    if estimator.kernel == "rbf":
        kernel = g.op("Exp", g.op("Mul", squared_distances(g, x, vectors), -float(estimator._gamma)))
    else:
        kernel = g.times(x, vectors.T)
    if len(estimator.classes_) == 2:
        decision = g.op("Add", g.times(kernel, estimator.dual_coef_.T), estimator.intercept_)
        return halves(g, decision)
    margins = _margins(g, estimator, kernel)
    n_classes = len(estimator.classes_)
    won, lost = _sides(n_classes)
    summed = g.times(margins, won - lost)
    share = g.op("Div", summed, g.op("Mul", g.op("Add", g.op("Abs", summed), 1.0), VOTE_SHARE))
    votes = _votes(g, g.op("GreaterOrEqual", margins, 0.0), won, lost)
    scores = g.op("Add", votes, share)
    if estimator.break_ties:
        return scores
    winner = g.op("ArgMax", _votes(g, g.op("Greater", margins, 0.0), won, lost), axis=1, keepdims=1)
    is_winner = g.op("Equal", np.arange(n_classes), winner)
    return g.op("Where", is_winner, g.op("ReduceMax", scores, integers(1), keepdims=1), scores)


def _margins(g: Graph, estimator: Any, kernel: str) -> str:
    """Decision (N, pairs) of each pair of classes, from kernel values (N, support vectors)."""
    counts = estimator.n_support_
    n_classes, most = len(counts), int(counts.max())
    starts = np.concatenate([[0], np.cumsum(counts)])
    place = np.zeros((n_classes, most), np.int64)
    dual = np.zeros((n_classes, most, n_classes - 1))
    for c, (start, count) in enumerate(zip(starts, counts, strict=False)):
        place[c, :count] = np.arange(start, start + count)
        dual[c, :count] = estimator.dual_coef_[:, start : start + count].T
    by_class = g.op("Unsqueeze", g.op("Gather", kernel, place, axis=1), integers(2))
    sums = g.op("Reshape", g.op("MatMul", by_class, dual), integers(0, n_classes * (n_classes - 1)))
    pairs = list(combinations(range(n_classes), 2))
    # class i keeps its coefficients against j > i in row j - 1, class j those against i < j in row i
    first = np.array([i * (n_classes - 1) + j - 1 for i, j in pairs])
    second = np.array([j * (n_classes - 1) + i for i, j in pairs])
    both = g.op("Add", g.op("Gather", sums, first, axis=1), g.op("Gather", sums, second, axis=1))
    return g.op("Add", both, np.asarray(estimator.intercept_, np.float64))


def _sides(n_classes: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(pairs, n_classes) one where a class is the first, and the second, of a pair."""
    pairs = np.array(list(combinations(range(n_classes), 2)))
    return np.eye(n_classes)[pairs[:, 0]], np.eye(n_classes)[pairs[:, 1]]


def _votes(g: Graph, first_wins: str, won: NDArray[np.float64], lost: NDArray[np.float64]) -> str:
    wins = g.double(first_wins)
    return g.op("Add", g.times(wins, won), g.times(g.op("Sub", 1.0, wins), lost))
