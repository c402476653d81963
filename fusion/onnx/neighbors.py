"""Nearest neighbours: uniform votes, votes 1 / d, and votes exp(-d)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.onnx.builder import Graph, integers
from fusion.onnx.distances import squared_distances


def weighted_neighbors(g: Graph, estimator: Any, x: str) -> str:
    """`fusion.WeightedKNN`: each class's part in the votes exp(-d)."""
    if estimator.novelty_threshold is not None:
        raise ValueError("WeightedKNN with a novelty_threshold answers a label of no class; use novelty_threshold=None")
    count = min(estimator.n_neighbors, len(estimator._samples))
    nearest, places = g.top(g.op("Sqrt", squared_distances(g, x, estimator._samples)), count)
    first = g.op("Slice", nearest, integers(0), integers(1), integers(1))
    votes = g.op("Exp", g.op("Sub", first, nearest))
    return shares(g, votes, places, estimator._sample_class, len(estimator.classes_))


def nearest_neighbors(g: Graph, estimator: Any, x: str) -> str:
    """scikit-learn's `KNeighborsClassifier` with Euclidean distances, `predict_proba` as scores."""
    metric, p = estimator.effective_metric_, dict(estimator.effective_metric_params_).get("p", 2)
    if metric not in ("euclidean", "minkowski") or p != 2:
        given = f"metric={estimator.metric!r}" + (f", p={estimator.p}" if estimator.metric == "minkowski" else "")
        raise ValueError(f"KNeighborsClassifier with {given} is not exported; use Euclidean")
    if estimator.weights not in ("uniform", "distance") or estimator.outputs_2d_ or not hasattr(estimator, "_fit_X"):
        raise ValueError("KNeighborsClassifier is exported with weights 'uniform' or 'distance' and one label a sample")
    rows = np.asarray(estimator._fit_X, np.float64)
    squared, places = g.top(squared_distances(g, x, rows), estimator.n_neighbors)
    if estimator.weights == "uniform":
        votes = g.op("Exp", g.op("Mul", squared, 0.0))
    else:
        votes = _inverse(g, g.op("Sqrt", squared))
    return shares(g, votes, places, np.asarray(estimator._y, np.int64), len(estimator.classes_))


def shares(g: Graph, votes: str, places: str, sample_class: NDArray[np.int64], n_classes: int) -> str:
    """Votes (N, k) of the samples at `places` (N, k), summed by class and divided by their sum: (N, n_classes)."""
    classes = g.op("Gather", np.eye(n_classes)[sample_class], places, axis=0)
    sums = g.sum(g.op("Mul", classes, g.op("Unsqueeze", votes, integers(2))), 1)
    return g.op("Div", sums, g.sum(sums, 1, keep=True))


def _inverse(g: Graph, distance: str) -> str:
    """1 / d; where a neighbour lies at 0, only such neighbours vote."""
    at_zero = g.op("Equal", distance, 0.0)
    inverse = g.op("Div", 1.0, g.op("Where", at_zero, 1.0, distance))
    found = g.op("ReduceMax", g.double(at_zero), integers(1), keepdims=1)
    return g.op("Where", g.op("Greater", found, 0.0), g.double(at_zero), inverse)
