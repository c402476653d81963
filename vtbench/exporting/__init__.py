"""A task's fitted pipelines as ONNX files: raw recordings in, scores of the task's classes out."""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOME = {
    "Order": "vtbench.exporting.fit",
    "Samples": "vtbench.exporting.fit",
    "export": "vtbench.exporting.write",
    "open_samples": "vtbench.exporting.fit",
}
__all__ = ["Order", "Samples", "export", "open_samples"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
