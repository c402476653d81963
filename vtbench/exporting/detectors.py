"""Slip detectors as ONNX files: fitted and given a threshold as a run does, checked on the trials of the test part."""

from __future__ import annotations

import json
import os
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from vtbench.exporting.write import METADATA_KEY, NotExactError
from vtbench.registry import unknown
from vtbench.run.detection.learning import LEARNT
from vtbench.run.detection.looking import frames_of, looks
from vtbench.run.detection.methods import DETECTORS
from vtbench.run.detection.thresholds import Fitted, fit
from vtbench.tasks import TASKS
from vtbench.tasks.slides import SlideData, SlipTask, load_slides

Kind = Literal["batch", "stream"]
MOST_SAMPLES = 200_000
"""Of force that are compared, whole trials: a stream takes some microseconds for each."""
TIE_UNITS = 2.0
"""A score within so many float32 units in the last place of the threshold is a tie."""
TOLERANCE = 1e-6
"""Largest difference of scores, as a part of the trial's largest: what float32 costs, and a little more."""


@dataclass(frozen=True, eq=False)
class Trials:
    """Trials of a slip task, and what names them."""

    task: SlipTask
    path: Path
    data: SlideData
    dataset_hash: str


@dataclass(frozen=True)
class DetectorOrder:
    """What to export: `rule` finds the threshold, `fit` is `train` (the first fold's training trials) or `all`."""

    detector: str
    rule: str | None = None
    variant: str | None = None
    split: str | None = None
    fit: Literal["train", "all"] = "train"
    seed: int = 0
    kind: Kind = "batch"


@dataclass(frozen=True)
class TrialParity:
    """What was measured of a graph on real trials.

    Attributes:
        trials, samples: compared.
        ties: samples whose score is within two float32 units of the threshold; left out of the agreement.
        agreement: part of the others that are at or above the threshold in both, or below it in both.
        largest_difference: of scores; `relative_difference` as a part of the trial's largest score.
        nan_samples: whether a reading of NaN, in each window that holds it and nowhere else, scored NaN.
        us_per_sample: median, one thread; a whole trial a call, or of a stream a sample a call.
    """

    trials: int
    samples: int
    ties: int
    agreement: float
    largest_difference: float
    relative_difference: float
    nan_samples: bool
    us_per_sample: float
    onnxruntime: str

    def problem(self) -> str:
        """Why the graph is not the detector; empty where it is."""
        if self.agreement < 1.0:
            return f"it is on the other side of the threshold in {1 - self.agreement:.2g} of the samples"
        if not self.relative_difference <= TOLERANCE:
            return f"its scores differ by {self.relative_difference:.2g} of the largest, expected at most {TOLERANCE:g}"
        return "" if self.nan_samples else "a reading of NaN does not score NaN, or spoils other samples"


def open_trials(task_id: str, path: Path | None) -> Trials:
    """Trials of a slip task from a dataset's folder.

    Raises:
        ValueError: no folder, or one that holds no slides.
    """
    from vtbench.data.meta import read_meta

    task = TASKS.get(task_id)
    assert isinstance(task, SlipTask)
    if path is None:
        raise ValueError(
            f"{task_id}: say on which trials: --data DIR (`vtbench generate fvsight-slip -o DIR` makes one)"
        )
    return Trials(task, path, load_slides((path,)), read_meta(path).hash)


def wanted(trials: Trials, order: DetectorOrder) -> dict[str, Any]:
    """What the report of a file must say for it to be the one that `order` asks for; see `vtbench.exporting.write`."""
    from vtbench.environment import version

    task = trials.task
    variant = order.variant or next(iter(task.variants))
    return {
        "task": task.id,
        "variant": variant,
        "modality": order.rule or next(iter(task.modalities)),
        "method": order.detector,
        "kind": order.kind,
        "split": order.split or next(iter(task.variants[variant].splits)),
        "fit": {"part": order.fit, "seed": order.seed},
        "dataset_hash": trials.dataset_hash,
        "vtbench": version(),
    }


def export_detector(trials: Trials, order: DetectorOrder, path: Path) -> dict[str, Any]:
    """Fit a detector as a run does, write its graph to `path`, return the report that stands in its metadata.

    Raises:
        ValueError: no exact graph, or trials that the detector or the threshold cannot be had from; one line.
        NotExactError: the graph was made and does not agree with the detector.
    """
    import onnx

    import slip
    from vtbench.data.files import write_whole

    fitted, train, test, names = _fit(trials, order)
    chosen = _few(trials.data, test)
    force = dict(trials.data.each_force(chosen))
    first = chosen[0]
    film = frames_of(trials.data, first) if looks(fitted.detector) else {}
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, "made.onnx")
        slip.export_onnx(fitted.detector, made, order.kind, force[first].shape[1], force[first], **film)
        model = onnx.load(made)
    parity = _measure(model.SerializeToString(), fitted, trials.data, force, order.kind)
    if problem := parity.problem():
        raise NotExactError(f"the graph is not the detector: {problem}; nothing was written")
    report = {**_identity(trials, order, fitted, names, len(train)), "parity": asdict(parity)}
    entry = model.metadata_props.add()
    entry.key, entry.value = METADATA_KEY, json.dumps(report, sort_keys=True)
    content = model.SerializeToString(deterministic=True)
    write_whole(path, lambda temporary: temporary.write_bytes(content))
    return {**report, "path": str(path), "bytes": os.path.getsize(path)}


def _fit(
    trials: Trials, order: DetectorOrder
) -> tuple[Fitted, NDArray[np.int64], NDArray[np.int64], tuple[str, str, str, str]]:
    """The detector with its threshold, its training and test trials, and the names of rule, variant, split, fold."""
    task = trials.task
    DETECTORS.get(order.detector)
    rule = order.rule or next(iter(task.modalities))
    if rule not in task.modalities:
        raise unknown(f"rule for the threshold of {task.id}", rule, task.modalities)
    variant = order.variant or next(iter(task.variants))
    if variant not in task.variants:
        raise unknown(f"variant of {task.id}", variant, task.variants)
    splits = task.variants[variant].splits
    split = order.split or next(iter(splits))
    if split not in splits:
        raise unknown(f"split of {task.id}, variant {variant}:", split, splits)
    fold = splits[split](trials.data, order.seed).folds[0]
    train, test, name = fold.train, fold.test, fold.name
    if order.fit == "all":
        train = test = np.arange(len(trials.data))
        name = "all"
    fitted = fit(order.detector, rule, trials.data, train, task.cfar_rate, task.window)
    return fitted, train, test, (rule, variant, split, name)


def _few(data: SlideData, test: NDArray[np.int64]) -> list[int]:
    """Whole test trials up to `MOST_SAMPLES`, one at least."""
    lengths = np.cumsum([data.truth[trial].samples for trial in test.tolist()])
    return [int(trial) for trial in test[: max(1, int(np.searchsorted(lengths, MOST_SAMPLES, side="right")))]]


def _measure(
    content: bytes, fitted: Fitted, data: SlideData, forces: dict[int, NDArray[np.float32]], kind: Kind
) -> TrialParity:
    import onnxruntime

    import slip

    graph = (slip.OnnxStream if kind == "stream" else slip.OnnxBatch)(content)
    apart, relative, right, ties, spent = [], [], [], 0, []
    for trial, force in forces.items():
        film = frames_of(data, trial) if looks(fitted.detector) else {}
        expected = np.asarray(fitted.detector.score(force, **film), np.float64)
        start = time.perf_counter()
        found = np.asarray(graph.score(force, **film), np.float64)
        spent.append((time.perf_counter() - start) / len(force) * 1e6)
        tie = np.abs(expected - fitted.beta) <= TIE_UNITS * np.spacing(np.float32(fitted.beta))
        ties += int(tie.sum())
        right.append(((found >= fitted.beta) == (expected >= fitted.beta))[~tie])
        apart.append(float(np.abs(found - expected).max()))
        relative.append(apart[-1] / max(float(np.abs(expected).max()), float(np.finfo(np.float32).tiny)))
    agreed = np.concatenate(right)
    first = next(iter(forces))
    film = frames_of(data, first) if looks(fitted.detector) else {}
    return TrialParity(
        trials=len(forces),
        samples=sum(len(force) for force in forces.values()),
        ties=ties,
        agreement=float(agreed.mean()) if len(agreed) else 1.0,
        largest_difference=max(apart),
        relative_difference=max(relative),
        nan_samples=_answers_nan(graph, forces[first], film, fitted.detector.settling),
        us_per_sample=float(np.median(spent)),
        onnxruntime=str(onnxruntime.__version__),
    )


def _answers_nan(graph: Any, force: NDArray[np.float32], film: dict[str, Any], settling: int) -> bool:
    """Whether NaN scores are those of the windows that hold the NaN, and all others what they were."""
    clean = graph.score(force, **film)
    for at, bad in _places(len(force), settling):
        spoiled = force.copy()
        spoiled[at, -1] = bad
        found = graph.score(spoiled, **film)
        told = np.zeros(len(force), bool)
        told[at : at + settling] = True
        if not np.array_equal(np.isnan(found), told):
            return False
        if not np.allclose(found[~told], clean[~told], rtol=1e-5, atol=1e-6 * float(np.abs(clean).max())):
            return False
    return True


def _places(length: int, settling: int) -> Iterator[tuple[int, float]]:
    yield length // 2, np.nan
    yield max(0, length - settling // 2 - 1), np.inf


def _identity(
    trials: Trials, order: DetectorOrder, fitted: Fitted, names: tuple[str, str, str, str], trained: int
) -> dict[str, Any]:
    """What decides the file, and the threshold that goes with it."""
    from vtbench.environment import version

    rule, variant, split, fold = names
    rates = sorted({truth.rate_hz for truth in trials.data.truth})
    return {
        "task": trials.task.id,
        "variant": variant,
        "modality": rule,
        "method": order.detector,
        "learns": order.detector in LEARNT,
        "kind": order.kind,
        "threshold": {"rule": rule, "alarm_at_or_above": fitted.beta, "periods": trials.task.periods},
        "settling": fitted.detector.settling,
        "rate_hz": rates[0] if len(rates) == 1 else rates,
        "split": split,
        "fit": {"part": order.fit, "fold": fold, "trials": trained, "seed": order.seed},
        "checked_on": "the test part" if order.fit == "train" else "the trials it was fitted on",
        "dataset_hash": trials.dataset_hash,
        "unit": "newtons",
        "vtbench": version(),
    }
