"""A cell's pipeline fitted on one training part and kept: features of new samples -> labels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.features import ModalityPCA
from vtbench.run.choose import Setting, within
from vtbench.run.methods.base import Classifier, Method
from vtbench.run.reduce import Floats, unit_scale
from vtbench.tasks.base import Block, Factor, Features, Feed


@dataclass(frozen=True)
class FittedBlock:
    """One block's way from features to columns, as `Reducer.at` takes it.

    Attributes:
        leading: columns that are used, None for all.
        transform: standardises, reduces, scales; None leaves the columns as they are.
        size: components kept of the transform's, None for all.
        scale: factor on what is kept, the block's weight in it.
    """

    leading: int | None
    transform: ModalityPCA | None
    size: int | None
    scale: float

    def apply(self, features: Features) -> Floats:
        """Columns (n, width) of features (n, columns)."""
        columns: Floats = features[:, : self.leading]
        if self.transform is not None:
            columns = np.asarray(self.transform.transform(columns))[:, : self.size]
        return columns * self.scale


@dataclass(frozen=True)
class FittedPipeline:
    """Blocks and the classifier that takes them side by side."""

    blocks: Mapping[str, FittedBlock]
    classifier: Classifier

    def columns(self, features: Mapping[str, Features]) -> Floats:
        """What the classifier takes (n, columns), of each block's features (n, its columns)."""
        return np.hstack([block.apply(features[name]) for name, block in self.blocks.items()])

    def predict(self, features: Mapping[str, Features]) -> NDArray[np.int64]:
        """Labels (n,) of each block's features (n, its columns)."""
        return self.classifier.predict(self.columns(features))


def fit_pipeline(
    method: Method,
    feed: Feed,
    setting: Setting,
    features: Mapping[str, Features],
    labels: NDArray[np.int64],
    apart: Factor | None = None,
) -> FittedPipeline:
    """Fit what `vtbench.run.choose.prepare` and `fit` do on a training part, for samples that come later.

    Args:
        features: block name -> training features (n, columns).
        labels: (n,) class indices.
        apart: (n,) condition that a method which learns holds back whole for its own choices.
    """
    blocks: dict[str, FittedBlock] = {}
    groups: dict[str, slice] = {}
    train: list[Floats] = []
    start = 0
    for block in feed.blocks:
        weight = 1.0 if method.weighs_groups else setting.weights[block.name]
        fitted = _fit_block(block, setting.sizes[block.name], features[block.name], method.preprocess, weight)
        train.append(fitted.apply(features[block.name]))
        groups[block.name] = slice(start, start := start + train[-1].shape[1])
        blocks[block.name] = fitted
    classifier = method.build(groups, setting.weights, within(setting.params, len(labels)))
    classifier.fit(np.hstack(train), labels, **({"groups": apart} if method.learns else {}))
    return FittedPipeline(blocks, classifier)


def _fit_block(block: Block, size: int | None, features: Features, preprocess: str, weight: float) -> FittedBlock:
    if preprocess == "none":
        return FittedBlock(size, None, None, weight)
    whole = {"all": slice(0, features.shape[1])}
    if block.leading:
        cut = features[:, :size]
        return FittedBlock(size, ModalityPCA({"all": slice(0, cut.shape[1])}).fit(cut), None, weight)
    most = max(block.components, default=None)
    counts = None if most is None else {"all": min(most, *features.shape)}
    transform = ModalityPCA(whole, counts).fit(features)
    reduced = np.asarray(transform.transform(features))
    if size is None or size >= reduced.shape[1]:
        return FittedBlock(None, transform, None, weight)
    return FittedBlock(None, transform, size, weight * unit_scale(reduced[:, :size]))
