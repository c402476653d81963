"""Features and classifiers for one or several modalities; scikit-learn estimators, no file access.

Names load on first use: `import fusion` imports neither scikit-learn nor torch.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOME = {
    "KSC": "fusion.sparse_coding",
    "JKSC": "fusion.sparse_coding",
    "kernel_omp_gram": "fusion.komp",
    "gram_lasso": "fusion.coordinate_descent",
    "GlobalAlignment": "fusion.sequence",
    "WeightedKNN": "fusion.neighbors",
    "ErrorEllipsoid": "fusion.ellipsoids",
    "error_ellipsoids": "fusion.ellipsoids",
}

__all__ = [
    "JKSC",
    "KSC",
    "ErrorEllipsoid",
    "GlobalAlignment",
    "WeightedKNN",
    "error_ellipsoids",
    "gram_lasso",
    "kernel_omp_gram",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
