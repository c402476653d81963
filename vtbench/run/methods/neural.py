"""Nets that learn from pixels and force histories, with the checkpoint chosen inside the training part.

Sizes and schedule are the estimators' defaults: nothing about them is tried on the folds of a cell, which would take
hours, so that a net is compared with methods that do choose.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from vtbench.run.methods.base import Classifier, Groups, Method, Params
from vtbench.tasks.presses import MODALITIES

SHAPES = {block.name: block.shape for feed in MODALITIES.values() for block in feed.blocks if block.shape is not None}
VERSION = 1
"""Raised when the nets or their defaults change."""


def _build(name: str, fixed: Params, groups: Groups, weights: Mapping[str, float], params: Params) -> Classifier:
    import fusion.neural

    net: Classifier = getattr(fusion.neural, name)(dict(groups), _shapes(groups), **fixed, **params)
    return net


def _shapes(groups: Groups) -> dict[str, tuple[int, ...]]:
    """Shape of each group that has one; the others are vectors."""
    return {name: SHAPES[name] for name in groups if name in SHAPES}


def _net(method_id: str, about: str, name: str, **fixed: Any) -> Method:
    return Method(
        method_id,
        about,
        partial(_build, name, fixed),
        preprocess="none",
        shaped=True,
        learns=True,
        source={"version": VERSION, **fixed},
    )


LATE_FUSION = _net(
    "late-fusion", "net with an encoder for each modality, joined late; learns for minutes", "LateFusionNet"
)
TRANSFORMER = _net(
    "fusion-transformer", "small transformer over patches, taxels and time; learns for minutes", "FusionTransformer"
)
LATE_FUSION_WHOLE = _net(
    "late-fusion-no-dropout", "late-fusion learnt without modality dropout", "LateFusionNet", modality_dropout=0.0
)
TRANSFORMER_WHOLE = _net(
    "fusion-transformer-no-dropout",
    "fusion-transformer learnt without modality dropout",
    "FusionTransformer",
    modality_dropout=0.0,
)
