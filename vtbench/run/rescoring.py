"""Scores taken again from the predictions on disk; no model runs."""

from __future__ import annotations

import time
from itertools import groupby
from pathlib import Path

from leaderboard.record import Record, read_predictions, read_records, write_record
from vtbench.run.folder import read_suite
from vtbench.run.records import scored
from vtbench.run.sources import find_sources, load_samples
from vtbench.run.suite import Suite
from vtbench.run.summary import RunSummary
from vtbench.tasks.base import Features, NotPossibleError


class NoFeatures:
    """Stands in for the feature cache: a score needs none."""

    def cached(self, identity: object, n: int, compute: object) -> Features:
        """Refuse: features are what a score must not need."""
        raise NotPossibleError("scoring reads no features")

    def us_per_sample(self, identity: object) -> None:
        """Nothing was measured."""
        return None


def rescore(run_dir: Path | str) -> RunSummary:
    """Score every prediction file of a run against the truth in its dataset and rewrite the records.

    Raises:
        ValueError: no run there, predictions missing or broken, a dataset that changed since; one line.
    """
    started = time.perf_counter()
    run_dir = Path(run_dir)
    suite = read_suite(run_dir)
    found = read_records(run_dir)
    records = sorted((record for record in found if record.submission is None), key=_samples)
    _check_unchanged(suite, run_dir, records)
    result = [record for record in found if record.submission is not None]  # scored when they were evaluated
    done = 0
    for (task_id, _, dataset), group in groupby(records, key=_samples):
        of_group = list(group)
        ok = [record for record in of_group if record.status.state == "ok"]
        result += [record for record in of_group if record.status.state != "ok"]
        if not ok:
            continue
        data = load_samples(suite, run_dir, task_id, dataset, NoFeatures())
        for record in ok:
            metrics, law = scored(record.identity, read_predictions(run_dir, record.key), data)
            again = record.model_copy(update={"metrics": metrics, "verdict": law})
            write_record(run_dir, again)
            result.append(again)
            done += 1
    return RunSummary.of(run_dir, result, done, time.perf_counter() - started)


def _check_unchanged(suite: Suite, run_dir: Path, records: list[Record]) -> None:
    """Refuse to score against other samples than those that were predicted; nothing is written before."""
    sources = find_sources(suite, run_dir).items()
    now = {(task, variant, source.dataset): source.hash for (task, variant, _), source in sources}
    for record in records:
        if record.status.state == "ok" and now.get(_samples(record)) != record.identity.dataset_hash:
            raise ValueError(
                f"{run_dir}: the dataset {record.identity.dataset!r} is not the one that was predicted; "
                "bring the old one back, or run the suite again"
            )


def _samples(record: Record) -> tuple[str, str, str]:
    return record.identity.task, record.identity.variant, record.identity.dataset
