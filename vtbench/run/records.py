"""Outcome of a cell + truth -> record."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from leaderboard.record import Identity, Metric, Provenance, Record, Status, Timing, Verdict
from vtbench.run.cells import Cell
from vtbench.run.detection.scoring import score_slips
from vtbench.run.evaluate import Outcome
from vtbench.run.scoring import Arrays, score, true_labels, verdict
from vtbench.tasks import TASKS
from vtbench.tasks.base import TaskData
from vtbench.tasks.slides import SlideData, SlipTask

TIMING_NOTE = "indicative: taken while other cells ran, classifier and its PCA; `feature` is the median over chunks"

DETECTOR_NOTE = "indicative: taken while other cells ran; the detector on a batch of 30,000 samples"


def record_of(cell: Cell, outcome: Outcome, data: TaskData, provenance: Mapping[str, Any]) -> Record:
    """Record of a cell that was run; `data` holds the truth."""
    metrics: tuple[Metric, ...] = ()
    law: Verdict | None = None
    timing = None
    if outcome.predictions is not None:
        metrics, law = scored(cell.identity, outcome.predictions, data)
        timing = Timing(
            threads=1,
            batch=outcome.batch,
            fit_s=outcome.fit_s,
            predict_us_per_sample=outcome.predict_us,
            feature_us_per_sample=_feature_us(cell, data),
            note=DETECTOR_NOTE if isinstance(data, SlideData) else TIMING_NOTE,
        )
    return Record(
        key=cell.key,
        identity=cell.identity,
        status=Status(state=outcome.state, reason=outcome.reason),
        metrics=metrics,
        timing=timing,
        verdict=law,
        provenance=Provenance(**provenance, started=_moment(outcome.started), finished=_moment(outcome.finished)),
    )


def skipped_record(cell: Cell, reason: str, provenance: Mapping[str, Any]) -> Record:
    """Row of a cell that cannot be run, with the reason."""
    now = datetime.now(UTC)
    return Record(
        key=cell.key,
        identity=cell.identity,
        status=Status(state="skipped", reason=reason),
        provenance=Provenance(**provenance, started=now, finished=now),
    )


def scored(identity: Identity, predictions: Arrays, data: TaskData) -> tuple[tuple[Metric, ...], Verdict | None]:
    """Metrics of predictions, and the verdict where the cell is a law."""
    task = TASKS.get(identity.task)
    if isinstance(task, SlipTask) and isinstance(data, SlideData):
        return score_slips(predictions, data, task), None
    metrics = score(predictions, true_labels(predictions, data.ids, data.labels))
    law = identity.params.get("law")
    return metrics, None if law is None else verdict(str(law), metrics[0], len(data.classes))


def _feature_us(cell: Cell, data: TaskData) -> float | None:
    """Time that the feed's measured blocks took a sample, microseconds; None where none was measured."""
    measured = [us for block in cell.feed.blocks if (us := data.feature_us(block.name)) is not None]
    return sum(measured) if measured else None


def _moment(seconds: float) -> datetime:
    return datetime.fromtimestamp(seconds, UTC)
