"""Scalers, principal components and linear decisions: subtract, multiply, project."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.onnx import add_estimator
from fusion.onnx.builder import Graph
from fusion.onnx.ends import halves


def project(g: Graph, x: str, mean: NDArray[np.float64], matrix: NDArray[np.float64]) -> str:
    """(x - mean) @ matrix, or times it column by column where it is a vector."""
    centred = g.op("Sub", x, np.asarray(mean, np.float64))
    matrix = np.asarray(matrix, np.float64)
    return g.op("Mul", centred, matrix) if matrix.ndim == 1 else g.times(centred, matrix)


def modality_pca(g: Graph, estimator: Any, x: str) -> str:
    """`fusion.features.ModalityPCA`."""
    parts = []
    for name, columns in estimator._columns.items():
        part = estimator._parts[name]
        inverse = part.scale / part.spread  # 0 for a constant column, whose spread is infinite
        matrix = inverse if part.axes is None else inverse[:, None] * part.axes.T
        parts.append(project(g, g.columns(x, columns, estimator.n_features_in_), part.mean, matrix))
    return parts[0] if len(parts) == 1 else g.op("Concat", *parts, axis=1)


def principal_components(g: Graph, estimator: Any, x: str) -> str:
    """scikit-learn's `PCA` and `IncrementalPCA`."""
    matrix = estimator.components_.T
    if estimator.whiten:
        matrix = matrix / np.sqrt(np.maximum(estimator.explained_variance_, np.finfo(np.float64).eps))
    return project(g, x, estimator.mean_, matrix)


def standard_scaler(g: Graph, estimator: Any, x: str) -> str:
    """scikit-learn's `StandardScaler`."""
    width = estimator.n_features_in_
    mean = estimator.mean_ if estimator.with_mean else np.zeros(width)
    return project(g, x, mean, 1.0 / estimator.scale_ if estimator.with_std else np.ones(width))


def linear_decision(g: Graph, estimator: Any, x: str) -> str:
    """scikit-learn's `LinearSVC` and `RidgeClassifier`: x @ coef + intercept, of two classes minus and plus half."""
    coef = np.atleast_2d(np.asarray(estimator.coef_, np.float64))
    decision = g.op("Add", g.times(x, coef.T), np.broadcast_to(estimator.intercept_, (len(coef),)).astype(np.float64))
    return halves(g, decision) if len(estimator.classes_) == 2 else decision


def pipeline(g: Graph, estimator: Any, x: str) -> str:
    """scikit-learn's `Pipeline`, step by step."""
    for _, step in estimator.steps:
        if step not in (None, "passthrough"):
            x = add_estimator(g, step, x)
    return x
