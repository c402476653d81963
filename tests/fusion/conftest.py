"""What several tests of fusion learn from."""

from collections.abc import Callable

import numpy as np
import pytest


@pytest.fixture
def clusters() -> Callable[..., tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Normal clusters: rows, labels, queries, and the queries' own labels."""
    return _clusters


def _clusters(seed=0, n_classes=5, per_class=8, n_queries=40, spread=0.7, d=12):
    rng = np.random.default_rng(seed)
    centres = rng.normal(size=(n_classes, d))
    y = np.arange(n_classes * per_class) % n_classes
    truth = np.arange(n_queries) % n_classes
    return (
        centres[y] + spread * rng.normal(size=(len(y), d)),
        y,
        centres[truth] + spread * rng.normal(size=(n_queries, d)),
        truth,
    )
