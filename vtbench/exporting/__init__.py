"""A task's fitted pipelines as ONNX files: raw recordings in, scores of the task's classes out."""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOME = {
    "DetectorOrder": "vtbench.exporting.detectors",
    "Order": "vtbench.exporting.fit",
    "Samples": "vtbench.exporting.fit",
    "Trials": "vtbench.exporting.detectors",
    "export": "vtbench.exporting.write",
    "export_detector": "vtbench.exporting.detectors",
    "open_samples": "vtbench.exporting.fit",
    "open_trials": "vtbench.exporting.detectors",
}
__all__ = [
    "DetectorOrder",
    "Order",
    "Samples",
    "Trials",
    "export",
    "export_detector",
    "open_samples",
    "open_trials",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
