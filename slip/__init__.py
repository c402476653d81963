"""Force sequences in, slip scores out."""

from __future__ import annotations

from importlib import import_module
from typing import Any

_DETECTORS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "covariance": ("slip.covariance", "Covariance", {}),
    "covariance-taxel": ("slip.covariance", "Covariance", {"side": "taxel"}),
    "covariance-mean-removed": ("slip.covariance", "Covariance", {"common_mode": "mean"}),
    "covariance-load-removed": ("slip.covariance", "Covariance", {"common_mode": "load"}),
    "covariance-load-ratio": ("slip.covariance", "Covariance", {"common_mode": "ratio"}),
    "energy": ("slip.energy", "Energy", {}),
    "energy-load-removed": ("slip.energy", "Energy", {"common_mode": "load"}),
    "spectral": ("slip.spectral", "Spectral", {}),
}

_LEARNT: dict[str, tuple[str, str, dict[str, Any]]] = {
    "neural-force": ("slip.neural", "NeuralForce", {}),
    "neural-force-frames": ("slip.neural", "NeuralForceFrames", {}),
}

_EXPORTS = {
    "AlarmRule": "slip.alarms",
    "Calibration": "slip.calibrate",
    "Covariance": "slip.covariance",
    "Detector": "slip.detector",
    "Energy": "slip.energy",
    "HoldOn": "slip.hold",
    "NeuralForce": "slip.neural",
    "NeuralForceFrames": "slip.neural",
    "OnnxBatch": "slip.onnx_run",
    "OnnxStream": "slip.onnx_run",
    "Parity": "slip.graph.parity",
    "Spectral": "slip.spectral",
    "TrainingTrial": "slip.training_trial",
    "Trial": "slip.alarms",
    "beta_of_slip": "slip.earlier_slip",
    "cfar": "slip.calibrate",
    "covariance_norm": "slip.covariance",
    "delay_at_rate": "slip.delay",
    "export_onnx": "slip.onnx",
    "hold_on": "slip.hold",
    "load_detector": "slip.neural",
    "prior": "slip.earlier_slip",
    "roc_by_trial": "slip.roc",
    "samples_of_frames": "slip.training_trial",
    "trial_table": "slip.scoring",
}

__all__ = [*_EXPORTS, "detector_names", "learnt_detector_names", "make_detector"]  # noqa: PLE0604, RUF100


def detector_names() -> tuple[str, ...]:
    """Names that `make_detector` takes for a detector that scores at once; "energy" is the baseline."""
    return tuple(_DETECTORS)


def learnt_detector_names() -> tuple[str, ...]:
    """Names that `make_detector` takes for a detector to `fit` on labelled trials first."""
    return tuple(_LEARNT)


def make_detector(name: str, **parameters: Any) -> Any:
    """Return a fresh detector of that name; `parameters` go to its class. Raises ValueError if unknown."""
    known = _DETECTORS | _LEARNT
    if name not in known:
        from difflib import get_close_matches

        close = get_close_matches(name, known, n=1)
        hint = f"did you mean {close[0]!r}?" if close else f"known are {', '.join(known)}"
        raise ValueError(f"unknown slip detector {name!r}: {hint}")
    module, attribute, defaults = known[name]
    return getattr(import_module(module), attribute)(**{**defaults, **parameters})


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
