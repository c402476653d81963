"""Backbones, PCA by modality and spectra. Names load on first use."""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOME = {
    "Backbone": "fusion.features.backbone",
    "backbone_names": "fusion.features.backbone",
    "get_backbone": "fusion.features.backbone",
    "is_own_file": "fusion.features.own_file",
    "import_torchvision": "fusion.features.torchvision_compat",
    "ModalityPCA": "fusion.features.pca",
    "FourierBasis": "fusion.features.spectrum",
    "ResampledSpectrum": "fusion.features.spectrum",
}

__all__ = [
    "Backbone",
    "FourierBasis",
    "ModalityPCA",
    "ResampledSpectrum",
    "backbone_names",
    "get_backbone",
    "import_torchvision",
    "is_own_file",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
