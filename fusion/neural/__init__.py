"""Nets that fuse modalities: late fusion, and a small transformer over patches, taxels and time.

Names load on first use: `import fusion.neural` imports neither scikit-learn nor torch.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOME = {
    "LateFusionNet": "fusion.neural.estimators",
    "FusionTransformer": "fusion.neural.estimators",
}

__all__ = ["FusionTransformer", "LateFusionNet"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
