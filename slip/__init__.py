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

_EXPORTS = {
    "AlarmRule": "slip.alarms",
    "Calibration": "slip.calibrate",
    "Covariance": "slip.covariance",
    "Detector": "slip.detector",
    "Energy": "slip.energy",
    "HoldOn": "slip.hold",
    "Spectral": "slip.spectral",
    "Trial": "slip.alarms",
    "cfar": "slip.calibrate",
    "covariance_norm": "slip.covariance",
    "delay_at_rate": "slip.delay",
    "hold_on": "slip.hold",
    "prior": "slip.earlier_slip",
    "roc_by_trial": "slip.roc",
    "trial_table": "slip.scoring",
}

__all__ = [*_EXPORTS, "detector_names", "make_detector"]  # noqa: PLE0604, RUF100


def detector_names() -> tuple[str, ...]:
    """Names that `make_detector` takes; "energy" is the baseline to show beside any other."""
    return tuple(_DETECTORS)


def make_detector(name: str, **parameters: Any) -> Any:
    """Return a fresh detector of that name; `parameters` go to its class. Raises ValueError if unknown."""
    if name not in _DETECTORS:
        from difflib import get_close_matches

        close = get_close_matches(name, _DETECTORS, n=1)
        hint = f"did you mean {close[0]!r}?" if close else f"known are {', '.join(_DETECTORS)}"
        raise ValueError(f"unknown slip detector {name!r}: {hint}")
    module, attribute, defaults = _DETECTORS[name]
    return getattr(import_module(module), attribute)(**{**defaults, **parameters})


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
