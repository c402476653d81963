"""Is a run whole? One line for each thing that is not."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from leaderboard.record import Record, read_predictions, scan_records
from vtbench.run.folder import SUITE_FILE, read_suite
from vtbench.run.planned import planned
from vtbench.run.sources import dataset_path
from vtbench.run.suite import Suite


def check_run(path: Path | str) -> list[str]:
    """Problems of a run's folder; empty when all is well.

    Looks at the suite, the datasets it names, every record, every prediction file, and whether every cell of the suite
    has its record. A folder that holds results of models that were handed in, and nothing else, has no suite.

    Raises:
        ValueError: no run there at all.
    """
    path = Path(path)
    records, problems = scan_records(path) if (path / "runs").is_dir() else ([], [])
    suite = None if only_handed_in(path, records) else read_suite(path)
    for record in records:
        problems += _prediction_problems(path, record)
    if suite is None:
        return problems
    return problems + _dataset_problems(suite, path) + _missing(suite, path, records)


def only_handed_in(path: Path, records: Sequence[Record]) -> bool:
    """Whether the records of a folder without a suite are all of models or predictions that were handed in."""
    suite_there = (path / SUITE_FILE).is_file()
    return not suite_there and bool(records) and all(record.submission is not None for record in records)


def _prediction_problems(path: Path, record: Record) -> list[str]:
    if record.status.state != "ok":
        return []
    where = path / "runs" / record.key
    try:
        arrays = read_predictions(path, record.key)
    except ValueError as error:
        return [str(error)]
    needed = ("sample_id", "group", "fold", "label")
    if lost := [name for name in needed if name not in arrays]:
        return [f"{where}: predictions without {', '.join(lost)}"]
    if len({len(arrays[name]) for name in needed}) != 1:
        return [f"{where}: prediction arrays of different lengths"]
    if "scores" in arrays and np.isnan(arrays["scores"]).any():
        return [f"{where}: NaN among the scores"]
    return []


def _dataset_problems(suite: Suite, path: Path) -> list[str]:
    from vtbench.data import check_dataset

    problems = []
    for spec in suite.datasets:
        folder = dataset_path(path, spec)
        if folder.is_dir():
            problems += check_dataset(folder)
        elif spec.path is not None:
            problems.append(f"{folder}: the suite's dataset {spec.id!r} is not there")
    return problems


def _missing(suite: Suite, path: Path, records: list[Record]) -> list[str]:
    try:
        cells = planned(suite, path)
    except ValueError as error:
        return [str(error)]
    there = {record.key for record in records}
    lost = [cell.identity for cell in cells if cell.key not in there]
    if not lost:
        return []
    first = lost[0]
    name = f"{first.task} {first.variant} {first.split} {first.modality} {first.method}"
    go_on = "the same `vtbench run` goes on"
    return [f"{path}: {len(lost)} of {len(cells)} cells have no record yet, {name} first; {go_on}"]
