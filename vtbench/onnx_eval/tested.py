"""On what a model is tested: recordings of a task, the part of them that counts, and how its scores become metrics."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import Metric
from vtbench.onnx_eval.hidden import HiddenSet
from vtbench.registry import unknown
from vtbench.run.rescoring import NoFeatures
from vtbench.run.scoring import score
from vtbench.run.sources import joined_hash
from vtbench.run.suite import DEFAULT_BACKBONE, JOIN
from vtbench.tasks import TASKS
from vtbench.tasks.base import Fold, Split, Task, TaskData
from vtbench.tasks.slides import SlideData, SlipTask, load_slides

WHOLE, HIDDEN = "all", "hidden"
GROUPS = ("unit", "setting", "object")
"""Conditions that an interval over every recording counts as one trial, the first that has two values or more."""
_SEVERAL = 2

Predictions = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Tested:
    """Recordings, protocol and split; `hidden` is the commitment where the recordings are a hidden set."""

    task: Task
    variant: str
    split: Split
    paths: tuple[Path, ...]
    data: TaskData
    dataset: str
    dataset_hash: str
    kind: Literal["simulated", "real"]
    seed: int = 0
    fold: str | None = None
    hidden: str | None = None

    @property
    def in_time(self) -> bool:
        """Whether scores are in time: of slip tasks."""
        return isinstance(self.task, SlipTask)

    @cached_property
    def samples(self) -> NDArray[np.int64]:
        """Samples that a model sees: those that are tested; of slip all, for thresholds come from the other trials."""
        if self.in_time:
            return np.arange(len(self.data))
        return np.unique(np.concatenate([fold.test for fold in self.split.folds]))

    def modality(self, inputs: Sequence[str]) -> str:
        """What tables say that the model is fed with; of a slip task the rule of its threshold."""
        if self.in_time:
            return "prior"
        frame = "fused" if {"force", "force_series"} & set(inputs) else "image"
        if not {"image", "image_rest"} & set(inputs):
            return "force-series" if "force_series" in inputs else "force"
        if "force_series" in inputs:
            return "force-series-image"
        rest = "image_rest" in inputs
        return ("fused-change" if frame == "fused" else "image-change") if rest else frame

    def params(self) -> dict[str, Any]:
        """JSON values that decide a result beside the names."""
        fold = {} if self.fold is None else {"fold": self.fold}
        return {**fold, **(self.task.protocol() if isinstance(self.task, SlipTask) else {})}

    def score(
        self, scores: Mapping[int, NDArray[np.float32]], us_per_sample: float
    ) -> tuple[Predictions, tuple[Metric, ...]]:
        """Predictions as they are kept, and their metrics, from the scores of each sample.

        Raises:
            NotPossibleError: slip scores that give no threshold.
        """
        if isinstance(self.task, SlipTask):
            return self._score_slips(scores, us_per_sample)
        tested = np.concatenate([fold.test for fold in self.split.folds])
        values = np.stack([scores[int(sample)].ravel() for sample in tested])
        lengths = [len(fold.test) for fold in self.split.folds]
        predictions = {
            "sample_id": self.data.ids[tested],
            "group": self.split.interval_groups[tested],
            "fold": np.repeat(np.arange(len(lengths), dtype=np.int32), lengths),
            "label": values.argmax(1).astype(np.int32),
            "scores": values,
        }
        return predictions, score(predictions, self.data.labels[tested])

    def _score_slips(
        self, scores: Mapping[int, NDArray[np.float32]], us_per_sample: float
    ) -> tuple[Predictions, tuple[Metric, ...]]:
        from vtbench.onnx_eval.slip_scores import RULE, slip_predictions
        from vtbench.run.detection.detect import DetectionWork
        from vtbench.run.detection.scoring import score_slips

        assert isinstance(self.task, SlipTask)
        assert isinstance(self.data, SlideData)
        work = DetectionWork("", "onnx", RULE, self.split, self.dataset_hash, self.data, self.task, 1e6)
        predictions = slip_predictions([scores[at] for at in range(len(self.data))], work, us_per_sample)
        metrics = score_slips(predictions, self.data, self.task)
        return predictions, tuple(metric for metric in metrics if metric.name != "stream_us")

    def seen_in_fitting(self, fitted_on: Mapping[str, str]) -> list[str]:
        """Why a model saw answers of this test when it was fitted, by what it says of itself.

        `vtbench export` writes `dataset_hash`, `variant`, `split`, `fold` and `seed`; a silent file is believed.
        """
        if fitted_on.get("dataset_hash") != self.dataset_hash:
            return []
        tested = {"variant": self.variant, "split": self.split.name, "fold": self.fold, "seed": str(self.seed)}
        if all(fitted_on.get(name) == value for name, value in tested.items()):
            return []
        if fitted_on.get("fold") == "all":
            return ["it says that it was fitted on all of these recordings; test it on others, or on a hidden set"]
        where = [f"--{name} {fitted_on[name]}" for name in tested if name in fitted_on]
        return [f"it says that it was fitted on some of these recordings; test it on the rest: {' '.join(where)}"]

    def doubts(self, claimed: float | None, metrics: tuple[Metric, ...]) -> list[str]:
        """A claim that the interval of what was measured does not hold."""
        if claimed is None or not metrics or metrics[0].low is None or metrics[0].high is None:
            return []
        low, high = metrics[0].low, metrics[0].high
        if low <= claimed <= high:
            return []
        measured = f"{100 * metrics[0].value:.1f} ({100 * low:.1f} to {100 * high:.1f})"
        return [f"claimed {100 * claimed:.1f} %, measured {measured} %"]


def on_datasets(
    task_id: str,
    variant: str | None,
    split: str | None,
    paths: Sequence[Path],
    *,
    fold: str | None = None,
    seed: int = 0,
) -> Tested:
    """Test on dataset folders, or without any on the public recordings that the task reads.

    `split` is one of the variant's, whose test parts are scored, or "all" (the default) for every recording.

    Raises:
        ValueError: unknown names, no dataset where one is needed, a split that the data do not allow.
    """
    task = TASKS.get(task_id)
    if task.reads_dataset and not paths:
        raise ValueError(
            f"{task_id}: say on which recordings: --data DIR (`vtbench generate` makes one) or --hidden-seed new"
        )
    name = _variant(task, variant)
    if task.reads_dataset:
        from vtbench.data.meta import read_meta

        metas = [read_meta(path) for path in paths]
        kind: Literal["simulated", "real"] = "simulated" if all(m.kind == "simulated" for m in metas) else "real"
        title, digest = JOIN.join(path.resolve().name for path in paths), joined_hash([meta.hash for meta in metas])
    else:
        from vtbench.data.public import data_root, public_set

        paths = paths or [data_root(task.reads)]
        digest = hashlib.sha256(public_set(task.reads).manifest.read_bytes()).hexdigest()
        kind, title = "real", task.reads
    data = _load(task, paths)
    chosen = _split(task, name, split, data, seed)
    return Tested(task, name, _only(chosen, fold), tuple(paths), data, title, digest, kind, seed, fold)


def on_hidden(task_id: str, variant: str | None, split: str | None, hidden: HiddenSet) -> Tested:
    """Test on every recording of a hidden set; of a slip task on a split of it, for its thresholds."""
    from vtbench.data.meta import read_meta

    task = TASKS.get(task_id)
    name = _variant(task, variant)
    paths = (hidden.path,)
    data = _unnamed(_load(task, paths))
    if isinstance(task, SlipTask):
        chosen = _split(task, name, split, data, 0)
    elif split not in (None, HIDDEN):
        raise ValueError(f"--split {split}: every recording of a hidden set is tested; leave it out")
    else:
        chosen = _whole(data, HIDDEN)
    meta = read_meta(hidden.path)
    return Tested(task, name, chosen, paths, data, hidden.name, meta.hash, "simulated", hidden=hidden.commitment)


def _unnamed(data: TaskData) -> TaskData:
    """Data whose ids and units only count: those of a hidden set would tell which sensors were drawn."""
    units = {}
    if "unit" in data.factors:
        units["unit"] = np.unique(data.factors["unit"], return_inverse=True)[1].ravel()
    ids = np.array([f"{at:06d}" for at in range(len(data))])
    return replace(data, ids=ids, factors={**data.factors, **units})


def _variant(task: Task, variant: str | None) -> str:
    if variant is None:
        return next(iter(task.variants))
    if variant not in task.variants:
        raise unknown(f"variant of {task.id}", variant, task.variants)
    if task.variants[variant].stand_ins:
        raise ValueError(f"{task.id}, {variant}, changes features inside a run: models see recordings as they are")
    return variant


def _load(task: Task, paths: Sequence[Path]) -> TaskData:
    if isinstance(task, SlipTask):
        return load_slides(paths)
    if len(paths) > 1:
        raise ValueError(f"{task.id}: expected one --data, got {len(paths)}; slip tasks read several together")
    return task.load(paths[0], NoFeatures(), DEFAULT_BACKBONE)


def _split(task: Task, variant: str, split: str | None, data: TaskData, seed: int) -> Split:
    rules = task.variants[variant].splits
    if isinstance(task, SlipTask):
        split = split or next(iter(rules))
    elif split in (None, WHOLE):
        return _whole(data, WHOLE)
    if split not in rules:
        more = () if isinstance(task, SlipTask) else (WHOLE,)
        raise unknown(f"split of {task.id}, variant {variant},", str(split), (*rules, *more))
    return rules[split](data, seed)


def _whole(data: TaskData, name: str) -> Split:
    """Every sample as one test part; the model was trained elsewhere."""
    groups, kind = data.ids, "sample"
    for factor in GROUPS:
        values = data.factors.get(factor)
        if values is not None and len(np.unique(values)) >= _SEVERAL:
            groups, kind = values, factor
            break
    fold = Fold(name, np.empty(0, np.int64), np.arange(len(data)))
    return Split(name, (fold,), np.asarray(groups).astype(np.str_), kind)


def _only(split: Split, fold: str | None) -> Split:
    if fold is None:
        return split
    names = [each.name for each in split.folds]
    if fold not in names:
        raise unknown(f"fold of {split.name}", fold, names)
    return Split(split.name, (split.folds[names.index(fold)],), split.interval_groups, split.group_kind)
