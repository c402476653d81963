"""What a task is made of: samples, splits, feeds, variants."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

Factor = NDArray[Any]
Features = NDArray[np.float32]


class NotPossibleError(ValueError):
    """A split or feed that these data do not allow, such as a held-out unit where there is one unit."""


class FeatureCache(Protocol):
    """Keeps features that cost time, under the content they come from."""

    def cached(self, identity: Mapping[str, str], n: int, compute: Callable[[NDArray[np.int64]], Features]) -> Features:
        """Features (n, columns); `compute` gets row indices and must be picklable."""

    def us_per_sample(self, identity: Mapping[str, str]) -> float | None:
        """What computing them took a sample, in microseconds, where they are kept."""


@dataclass(frozen=True)
class Block:
    """Feature columns that belong together, and what may be chosen about them on training folds.

    Attributes:
        name: what `TaskData.block` calls them.
        components: choices for the number of principal components, smallest first; empty keeps the columns.
        leading: choices for the number of leading columns kept, smallest first; empty keeps all.
        from_frames: made by a backbone, so that a result depends on which.
        shape: how the columns fold, for a net: (channels, rows, columns) of pixels, (steps, channels) of a series;
            -1 stands for what is left. None where they are plain numbers.
    """

    name: str
    components: tuple[int, ...] = ()
    leading: tuple[int, ...] = ()
    from_frames: bool = False
    shape: tuple[int, ...] | None = None

    @property
    def sizes(self) -> tuple[int, ...]:
        """Choices for the number of columns, smallest first; empty where nothing is to choose."""
        return self.components or self.leading


@dataclass(frozen=True)
class Feed:
    """What a classifier is fed.

    Attributes:
        blocks: feature blocks, concatenated in this order.
        weights: blocks weighed all alike, or with weights chosen on training folds.
        shuffle_labels: train on permuted labels.
        needs_truth: ground-truth field that the dataset must hold.
        by_name: run only where a suite names it.
    """

    blocks: tuple[Block, ...]
    weights: Literal["equal", "chosen"] = "equal"
    shuffle_labels: bool = False
    needs_truth: str | None = None
    by_name: bool = False

    @property
    def shaped(self) -> bool:
        """Whether every block says how its columns fold, as nets need."""
        return all(block.shape is not None for block in self.blocks)


@dataclass(eq=False)
class TaskData:
    """Samples of one task; features are computed when first asked for.

    Attributes:
        ids: (n,) sample ids.
        labels: (n,) class indices.
        classes: names of the classes.
        factors: (n,) values of each condition that a split stratifies by or holds out (`unit`, `session`).
        rows: (n,) row of each sample in its dataset.
        sources: features (rows of the dataset, columns) by block name.
        feature_us: microseconds a sample that a block took, where it was measured.
    """

    ids: NDArray[np.str_]
    labels: NDArray[np.int64]
    classes: tuple[str, ...]
    factors: Mapping[str, Factor]
    rows: NDArray[np.int64]
    sources: Mapping[str, Callable[[], Features]]
    feature_us: Callable[[str], float | None] = lambda block: None
    _blocks: dict[str, Features] = field(default_factory=dict, repr=False)

    def __len__(self) -> int:
        return len(self.ids)

    def block(self, name: str) -> Features:
        """Features (n, columns) of one block, kept after the first call.

        Raises:
            NotPossibleError: the dataset does not hold what the block is made from.
        """
        if name not in self._blocks:
            if name not in self.sources:
                raise NotPossibleError(f"these data hold no {name!r}; there are {', '.join(self.sources)}")
            self._blocks[name] = np.ascontiguousarray(self.sources[name]()[self.rows], np.float32)
        return self._blocks[name]

    def factor(self, name: str) -> Factor:
        """(n,) values of a condition; NotPossibleError where the data do not name it."""
        if name not in self.factors:
            raise NotPossibleError(f"these data do not say the {name} of a sample")
        return self.factors[name]

    def take(self, keep: NDArray[np.bool_]) -> TaskData:
        """The samples where `keep` is true."""
        return TaskData(
            ids=self.ids[keep],
            labels=self.labels[keep],
            classes=self.classes,
            factors={name: values[keep] for name, values in self.factors.items()},
            rows=self.rows[keep],
            sources=self.sources,
            feature_us=self.feature_us,
        )


@dataclass(frozen=True, eq=False)
class Fold:
    """Row indices of one training part and of the test part that its model sees once."""

    name: str
    train: NDArray[np.int64]
    test: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Split:
    """A named set of folds.

    Attributes:
        interval_groups: (n,) group of each sample; an interval counts a group as one trial.
        group_kind: what a group is, in the singular (`press`, `unit`).
        inner_groups: (n,) condition that the folds for choices inside a training part hold out too, or None.
    """

    name: str
    folds: tuple[Fold, ...]
    interval_groups: NDArray[np.str_]
    group_kind: str
    inner_groups: Factor | None = None


SplitRule = Callable[[TaskData, int], Split]
"""(data, seed) -> split."""


@dataclass(frozen=True)
class StandIn:
    """Names of the blocks that are read in place of one: None is the block itself.

    Attributes:
        train: for training, and for all that is chosen there.
        test: for the test part; `MISSING` takes the modality away.
    """

    train: str | None = None
    test: str | None = None


MISSING = "missing"


@dataclass(frozen=True)
class Variant:
    """One protocol of a task.

    Attributes:
        about: one line for listings.
        splits: rule of each split, by name.
        laws: what a feed's accuracy must be on this variant, whatever the method.
        stand_ins: by block, what is read in its place.
    """

    about: str
    splits: Mapping[str, SplitRule]
    laws: Mapping[str, Literal["perfect", "chance"]] = field(default_factory=dict)
    stand_ins: Mapping[str, StandIn] = field(default_factory=dict)


@dataclass(frozen=True)
class Task:
    """One question, put to every method on the same terms.

    Attributes:
        id: versioned; a change that can move a score takes a new version.
        about: one line for listings.
        reads: a dataset of presses or of slides, or the public recordings of that name.
        load: (folder, feature cache, backbone) -> samples.
        variants: protocols by name.
        modalities: feeds that are compared.
        probes: feeds that should not suffice.
        upper_lines: feeds that no sensor gives.
    """

    id: str
    about: str
    reads: Literal["presses", "slides", "fabricslide16", "biotacsp_stability_v2"]
    load: Callable[[Path, FeatureCache, str], TaskData]
    variants: Mapping[str, Variant]
    modalities: Mapping[str, Feed]
    probes: Mapping[str, Feed]
    upper_lines: Mapping[str, Feed] = field(default_factory=dict)

    @property
    def kind(self) -> Literal["simulated", "real"]:
        """Whether the recordings are real where the suite does not bring its own."""
        return "simulated" if self.reads_dataset else "real"

    @property
    def reads_dataset(self) -> bool:
        """Whether the suite says which dataset; public recordings say so themselves."""
        return self.reads in ("presses", "slides")

    def feed(self, name: str) -> Feed:
        """The modality, probe or upper line of that name."""
        return {**self.modalities, **self.probes, **self.upper_lines}[name]
