"""Nearest neighbours, uniform and weighted by exp(-distance)."""

from __future__ import annotations

from collections.abc import Mapping

from vtbench.run.methods.base import Classifier, Groups, Method, Params


def _uniform(groups: Groups, weights: Mapping[str, float], params: Params) -> Classifier:
    from sklearn.neighbors import KNeighborsClassifier

    return KNeighborsClassifier(algorithm="brute", **params)


def _weighted(groups: Groups, weights: Mapping[str, float], params: Params) -> Classifier:
    from fusion import WeightedKNN

    return WeightedKNN(**params)


UNIFORM = Method("knn", "nearest neighbours, one vote each", _uniform, {"n_neighbors": (1, 3, 5)})
WEIGHTED = Method("wknn", "nearest neighbours, votes exp(-distance)", _weighted, {"n_neighbors": (3, 5, 10)})
