"""A subject loaded in its own process: what one call does, on which samples."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import read_predictions
from vtbench.run.cells import Cell
from vtbench.run.choose import Setting
from vtbench.run.features import DiskFeatures
from vtbench.run.fitted import fit_pipeline
from vtbench.run.methods import Method
from vtbench.run.sources import load_samples, source_paths
from vtbench.run.suite import Suite
from vtbench.tasks.base import Fold, TaskData
from vtbench.tasks.slides import SlideData, SlipTask
from vtbench.timing.graph_cost import GraphCost, graph_cost, pipeline_cost

LARGE = 100
SEQUENCE = 30_000
"""Samples of the sequence that a detector scores whole."""

Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Ready:
    """What is timed, ready to be called.

    Attributes:
        one: does the work of sample i.
        many: does the work of the large batch that begins at sample i.
        n: samples to rotate through.
        large: samples in the large batch.
        count: what it costs on any machine; None where it has no graph.
    """

    one: Callable[[int], object]
    many: Callable[[int], object]
    n: int
    large: int
    count: Callable[[], GraphCost | None] = lambda: None


def load_features(cell: Cell, suite: Suite, out: Path, block: str) -> Ready:
    """Frames in memory; a call turns some of them into features, the difference to the rest frame included."""
    from fusion.features import get_backbone
    from vtbench.data import Dataset
    from vtbench.tasks.presses import change

    (path, *_) = source_paths(suite, out, cell.identity.task, cell.identity.dataset)
    dataset = Dataset.open(path, verify=False)
    rows = np.arange(min(LARGE, dataset.n))
    frames = dataset.images(rows)
    rest = dataset.images(rows, column="image_rest") if block == "image-change" else None
    backbone = get_backbone(cell.backbone)

    def work(start: int, stop: int) -> object:
        shown = frames[start:stop]
        return backbone.extract(shown if rest is None else change(shown, rest[start:stop]))

    def count() -> GraphCost:
        return graph_cost(backbone.onnx_model(), {"images": (1, *frames.shape[1:])})

    return Ready(lambda i: work(i, i + 1), lambda i: work(0, len(frames)), len(frames), len(frames), count)


def load_classifier(cell: Cell, suite: Suite, out: Path) -> Ready:
    """The pipeline of the first fold, as the run chose it, on the features of its test part."""
    data, fold = _first_fold(cell, suite, out)
    assert isinstance(cell.method, Method)
    setting = Setting(**json.loads(str(read_predictions(out, cell.key)["choices"][0])))
    blocks = {block.name: data.block(block.name) for block in cell.feed.blocks}
    train = {name: block[fold.train] for name, block in blocks.items()}
    pipeline = fit_pipeline(cell.method, cell.feed, setting, train, data.labels[fold.train])
    test = {name: block[fold.test] for name, block in blocks.items()}
    n = len(fold.test)
    large = np.arange(LARGE)
    return Ready(
        lambda i: pipeline.predict({name: block[i : i + 1] for name, block in test.items()}),
        lambda i: pipeline.predict({name: block[(i + large) % n] for name, block in test.items()}),
        n,
        LARGE,
        lambda: pipeline_cost(pipeline, {name: block.shape[1] for name, block in blocks.items()}),
    )


def load_detector(cell: Cell, suite: Suite, out: Path) -> Ready:
    """The detector of the first fold; one sample is an update of the stream, the large batch a whole sequence."""
    from vtbench.run.detection.thresholds import fit, seen

    data, fold = _first_fold(cell, suite, out)
    task = cell.task
    assert isinstance(data, SlideData)
    assert isinstance(task, SlipTask)
    feed = cell.identity.modality
    detector = fit(cell.identity.method, feed, data, fold.train, task.cfar_rate, task.window).detector
    force = seen(next(data.each_force(fold.test[:1]))[1], feed)
    sequence = np.asarray(force, np.float64)[np.arange(SEQUENCE) % len(force)]
    return Ready(lambda i: detector.update(sequence[i]), lambda i: detector.score(sequence), SEQUENCE, SEQUENCE)


def _first_fold(cell: Cell, suite: Suite, out: Path) -> tuple[TaskData, Fold]:
    cache = DiskFeatures(out / "features")
    data = load_samples(suite, out, cell.identity.task, cell.identity.dataset, cache, cell.backbone)
    rule = cell.task.variants[cell.identity.variant].splits[cell.identity.split]
    return data, rule(data, cell.identity.seed).folds[0]
