"""A suite from its file to records: datasets, features, cells, scores; what is finished is never done again."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

from leaderboard.record import Record, has_predictions, scan_records, write_record
from vtbench.run.cells import Cell, own_methods, plan
from vtbench.run.folder import claim, drop_records, set_aside
from vtbench.run.methods import Method
from vtbench.run.sources import find_sources, load_samples, prepare_datasets
from vtbench.run.suite import Suite
from vtbench.run.summary import RunSummary
from vtbench.scheduling import Cluster


def run_suite(
    suite: Suite,
    out: Path | str,
    *,
    jobs: int = 1,
    cluster: Cluster | None = None,
    fresh: bool = False,
    device: str = "cpu",
    progress: bool = True,
) -> RunSummary:
    """Run what is missing of a suite in folder `out`.

    Datasets, features and records are each whole or absent: killed at any moment, the same call goes on and ends with
    the same records, timings apart. A finished key is not run again; a failed one keeps its row.

    Args:
        suite: what to run.
        out: folder of the run, `suite.yaml`, `datasets/`, `features/` and `runs/` below it.
        jobs: processes; each computes with one thread.
        cluster: workers elsewhere instead (`vtbench.scheduling.connect`), which see the folder of the run.
        fresh: drop the records and run every cell again; datasets and features stay, their bytes cannot differ, and so
            do records of models that were handed in.
        device: `cpu`; the backbones run there.
        progress: show bars on standard error when it is a terminal.

    Raises:
        ValueError: an argument out of range, a folder of another suite, a dataset of another plan, an own method
            that cannot be made.
        OSError: the folder cannot be written.
    """
    started = time.perf_counter()
    out = Path(out)
    if jobs < 1:
        raise ValueError(f"jobs: expected at least 1, got {jobs}")
    if device != "cpu":
        raise ValueError(
            f"device: expected 'cpu', got {device!r}: backbones and classifiers run on the CPU on every "
            "machine alike; `vtbench train-backbone --device cuda` trains on a GPU"
        )
    methods = own_methods(suite)
    out = out if cluster is None else out.resolve()
    with claim(out, suite):
        if cluster is not None:
            cluster.shares(out)
        if fresh:
            drop_records(out)
        prepare_datasets(suite, out, jobs, progress, cluster)
        cells = plan(suite, find_sources(suite, out), _backbone(suite), methods)
        set_aside(out, {cell.key for cell in cells})
        records = _records(out)
        pending = [cell for cell in cells if not _finished(cell, records.get(cell.key), out)]
        if pending:
            for record in _run(suite, out, pending, jobs, progress, cluster):
                records[record.key] = record
    return RunSummary.of(out, [records[cell.key] for cell in cells], len(pending), time.perf_counter() - started)


def _finished(cell: Cell, record: Record | None, out: Path) -> bool:
    """A record stands with its predictions; a skipped row of public recordings that have come since runs again."""
    if record is None or (record.status.state == "ok" and not has_predictions(out, cell.key)):
        return False
    return not (record.status.state == "skipped" and not cell.task.reads_dataset and not cell.missing)


def _records(out: Path) -> dict[str, Record]:
    """Readable records by key; one that is broken counts as missing."""
    if not (out / "runs").is_dir():
        return {}
    return {record.key: record for record in scan_records(out)[0]}


def _backbone(suite: Suite) -> dict[str, str]:
    """What decides the features of frames."""
    from vtbench.tasks.presses import backbone_identity

    return backbone_identity(suite.backbone)


def _run(
    suite: Suite, out: Path, cells: list[Cell], jobs: int, progress: bool, cluster: Cluster | None
) -> Iterator[Record]:
    """Records of the cells, written as they come."""
    from threadpoolctl import threadpool_limits

    from vtbench.run.methods.external import check_external
    from vtbench.run.progress import bar
    from vtbench.run.provenance import provenance

    for method in {cell.method.id: cell.method for cell in cells if "estimator" in cell.method.source}.values():
        if isinstance(method, Method):
            check_external(method)
    where = provenance()
    with threadpool_limits(1), bar(len(cells), "cells", progress) as advance:
        for _, group in groupby(cells, key=lambda cell: cell.group):
            for record, predictions in _run_group(suite, out, list(group), where, jobs, progress, cluster):
                write_record(out, record, predictions)
                advance(1)
                yield record


def _run_group(
    suite: Suite,
    out: Path,
    cells: list[Cell],
    where: Mapping[str, Any],
    jobs: int,
    progress: bool,
    cluster: Cluster | None,
) -> Iterator[tuple[Record, Mapping[str, Any] | None]]:
    """Cells that read the same samples."""
    from vtbench.run.executor import run_all
    from vtbench.run.features import DiskFeatures
    from vtbench.run.records import record_of, skipped_record
    from vtbench.run.work import works_of

    if cells[0].missing:
        yield from ((skipped_record(cell, cell.missing, where), None) for cell in cells)
        return
    task_id, _, dataset, backbone = cells[0].group
    cache = DiskFeatures(out / "features", jobs, progress, cluster)
    data = load_samples(suite, out, task_id, dataset, cache, backbone)
    works, impossible = works_of(cells, data)
    by_key = {cell.key: cell for cell in cells}
    yield from ((skipped_record(by_key[key], reason, where), None) for key, reason in impossible.items())
    for outcome in run_all(works, jobs, cluster):
        yield record_of(by_key[outcome.key], outcome, data, where), outcome.predictions
