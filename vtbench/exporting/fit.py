"""The pipeline that is exported: chosen and fitted by the functions of a run, on a training part that is named."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vtbench.registry import unknown
from vtbench.run.choose import Setting, choose
from vtbench.run.fitted import FittedPipeline, fit_pipeline
from vtbench.run.methods import METHODS, Method
from vtbench.run.methods.external import check_external, external_method
from vtbench.run.reduce import Reducer
from vtbench.run.suite import opened_backbone
from vtbench.tasks import TASKS
from vtbench.tasks.base import FeatureCache, Features, Feed, Fold, Task, TaskData

Fit = Literal["train", "all"]


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of a task, and what names them.

    Attributes:
        path: folder of the dataset or of the public recordings.
        dataset_hash: as records state it.
        backbone: name of the network that turns frames into features, or its ONNX file.
    """

    task: Task
    path: Path
    data: TaskData
    dataset_hash: str
    backbone: str


@dataclass(frozen=True)
class Order:
    """What to export.

    Attributes:
        method: id of a method, or an import path `package.module:Class` of a scikit-learn classifier.
        modality: name of a feed; the task's first by default.
        variant, split: of the task; the first by default.
        fit: `train` is the training part of the split's first fold, so that its test part is left to check on; `all`
            takes every sample, and checks on samples that it has seen.
        seed: of the split's draws, as a suite's.
    """

    method: str
    modality: str | None = None
    variant: str | None = None
    split: str | None = None
    fit: Fit = "train"
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Fitted:
    """A fitted pipeline with what it was fitted on, and the rows left to check it on."""

    method: Method
    feed: Feed
    modality: str
    variant: str
    split: str
    fold: Fold
    setting: Setting
    pipeline: FittedPipeline

    def features(self, samples: Samples, rows: NDArray[np.int64]) -> dict[str, Features]:
        """Features of some samples by block."""
        return {block.name: samples.data.block(block.name)[rows] for block in self.feed.blocks}


def open_samples(task_id: str, path: Path | None, backbone: str, cache: FeatureCache) -> Samples:
    """Samples of a task from a dataset's folder; public recordings are found where `vtbench fetch` put them.

    Raises:
        ValueError: a task of slip, no such backbone, a folder that is missing, or recordings that are not on this
            machine.
    """
    task = TASKS.get(task_id)
    if task.reads == "slides":
        raise ValueError(f"{task.id} is a task of slip: its trials are opened by open_trials()")
    opened_backbone(backbone)
    if task.reads_dataset:
        from vtbench.data.meta import read_meta

        if path is None:
            raise ValueError(f"{task.id}: expected the folder of a dataset")
        return Samples(task, path, task.load(path, cache, backbone), read_meta(path).hash, backbone)
    from vtbench.data.public import data_root, public_set

    if path is not None:
        raise ValueError(f"{task.id} reads the public recordings {task.reads}; leave --data out")
    root = data_root(task.reads)
    digest = hashlib.sha256(public_set(task.reads).manifest.read_bytes()).hexdigest()
    return Samples(task, root, task.load(root, cache, backbone), digest, backbone)


def method_of(name: str) -> Method:
    """A registered method, or somebody's own classifier by import path.

    Raises:
        ValueError: neither.
    """
    if ":" not in name:
        return METHODS.get(name)
    method = external_method(name.partition(":")[2].lower(), name, {}, {})
    check_external(method)
    return method


def fit_order(samples: Samples, order: Order) -> Fitted:
    """Choose and fit as a run does on that split; the choices see training rows alone.

    Raises:
        ValueError: a name that the task does not have, or a feed that is none for the method.
    """
    task, data, method = samples.task, samples.data, method_of(order.method)
    modality = order.modality or next(iter(task.modalities))
    if modality not in task.modalities:
        raise unknown(f"modality of {task.id}", modality, task.modalities)
    variant = order.variant or next(iter(task.variants))
    if variant not in task.variants:
        raise unknown(f"variant of {task.id}", variant, task.variants)
    splits = task.variants[variant].splits
    name = order.split or next(iter(splits))
    if name not in splits:
        raise unknown(f"split of {task.id}, variant {variant}:", name, splits)
    if task.variants[variant].stand_ins:
        raise ValueError(f"{task.id}, {variant} breaks its own samples on purpose; export {next(iter(task.variants))}")
    feed = task.modalities[modality]
    if method.joint and len(feed.blocks) < 2:
        raise ValueError(f"{method.id} joins two modalities and {modality} is one; use ksc, or a fused modality")
    if feed.shaped < method.shaped:
        raise ValueError(f"{method.id} takes shaped features, which {modality} has not; use a modality of pixels")
    split = splits[name](data, order.seed)
    fold = split.folds[0]
    if order.fit == "all":
        every = np.arange(len(data))
        fold = Fold("all", every, every)
    blocks = {block.name: data.block(block.name) for block in feed.blocks}
    known = data.labels[fold.train]
    inner = None if split.inner_groups is None else split.inner_groups[fold.train]
    setting = choose(method, feed, Reducer(blocks, method.preprocess), fold.train, known, inner, order.seed)
    training = {block: values[fold.train] for block, values in blocks.items()}
    pipeline = fit_pipeline(method, feed, setting, training, known, inner)
    scores = any(hasattr(pipeline.classifier, name) for name in ("decision_function", "predict_proba"))
    if not (scores and hasattr(pipeline.classifier, "classes_")):
        raise ValueError(
            f"{order.method} is not a classifier with scores; give it classes_ and decision_function or predict_proba"
        )
    return Fitted(method, feed, modality, variant, name, fold, setting, pipeline)
