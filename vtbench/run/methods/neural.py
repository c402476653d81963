"""Nets that learn from pixels and force histories, with the checkpoint chosen inside the training part.

Sizes and schedule are the estimators' defaults: nothing about them is tried on the folds of a cell, which would take
hours, so that a net is compared with methods that do choose.
"""

from __future__ import annotations

from collections.abc import Mapping

from vtbench.run.methods.base import Classifier, Groups, Method, Params
from vtbench.tasks.presses import MODALITIES

SHAPES = {block.name: block.shape for feed in MODALITIES.values() for block in feed.blocks if block.shape is not None}
VERSION = 1
"""Raised when the nets or their defaults change."""


def _late_fusion(groups: Groups, weights: Mapping[str, float], params: Params) -> Classifier:
    from fusion.neural import LateFusionNet

    return LateFusionNet(dict(groups), _shapes(groups), **params)


def _transformer(groups: Groups, weights: Mapping[str, float], params: Params) -> Classifier:
    from fusion.neural import FusionTransformer

    return FusionTransformer(dict(groups), _shapes(groups), **params)


def _shapes(groups: Groups) -> dict[str, tuple[int, ...]]:
    """Shape of each group that has one; the others are vectors."""
    return {name: SHAPES[name] for name in groups if name in SHAPES}


LATE_FUSION = Method(
    "late-fusion",
    "net with an encoder for each modality, joined late; learns for minutes",
    _late_fusion,
    preprocess="none",
    shaped=True,
    learns=True,
    source={"version": VERSION},
)
TRANSFORMER = Method(
    "fusion-transformer",
    "small transformer over patches, taxels and time; learns for minutes",
    _transformer,
    preprocess="none",
    shaped=True,
    learns=True,
    source={"version": VERSION},
)
