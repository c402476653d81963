"""Right and wrong by group for every classified cell of a run, from its predictions and the truth in its dataset."""

from __future__ import annotations

from contextlib import suppress
from itertools import groupby
from pathlib import Path

from leaderboard.record import Record, read_predictions
from leaderboard.tally import Tally, read_tallies, tally, write_tally
from vtbench.run.folder import read_suite
from vtbench.run.rescoring import NoFeatures
from vtbench.run.scoring import true_labels
from vtbench.run.sources import find_sources, load_samples
from vtbench.tasks import TASKS
from vtbench.tasks.slides import SlipTask


def run_tallies(run_dir: Path, records: list[Record]) -> tuple[dict[str, Tally], list[str]]:
    """Tallies of a run's records by key, and one line for each set of samples that cannot be had.

    Those that a record keeps are read; the others are counted from its predictions, which takes the dataset they were
    made on. A folder without a suite gives what its records keep.
    """
    found = read_tallies(run_dir)
    wanted = [record for record in records if record.key not in found and _classified(record)]
    if not wanted or not (run_dir / "suite.yaml").is_file():
        return found, []
    problems: list[str] = []
    try:
        suite = read_suite(run_dir)
        sources = find_sources(suite, run_dir)
    except (ValueError, OSError) as error:
        return found, [f"{run_dir}: methods are compared without pairing: {error}"]
    now = {(task, variant, source.dataset): source.hash for (task, variant, _), source in sources.items()}
    for (task, variant, dataset), group in groupby(sorted(wanted, key=_samples), key=_samples):
        of_group = list(group)
        same = [r for r in of_group if now.get((task, variant, dataset)) == r.identity.dataset_hash]
        if not same:
            if all(r.submission is not None for r in of_group):
                continue  # a hidden test set is not among the run's datasets
            problems.append(f"{run_dir}: methods of {task}, {variant}, are compared without pairing: other samples now")
            continue
        try:
            data = load_samples(suite, run_dir, task, dataset, NoFeatures())
        except (ValueError, OSError) as error:
            problems.append(f"{run_dir}: methods of {task}, {variant}, are compared without pairing: {error}")
            continue
        for record in same:
            try:
                arrays = read_predictions(run_dir, record.key)
                correct = arrays["label"] == true_labels(arrays, data.ids, data.labels)
                found[record.key] = tally(correct, arrays["group"], arrays["sample_id"], arrays["fold"])
                _keep(run_dir / "runs" / record.key, found[record.key])
            except (ValueError, KeyError) as error:
                problems.append(f"{run_dir}: {record.key[:12]} is compared without pairing: {error}")
    return found, problems


def _keep(folder: Path, value: Tally) -> None:
    """Leave a tally beside its record, where the folder can be written, so that it need not be counted again."""
    with suppress(OSError):
        write_tally(folder, value)


def _classified(record: Record) -> bool:
    who = record.identity
    if record.status.state != "ok" or who.task not in TASKS.ids():
        return False
    return not isinstance(TASKS.get(who.task), SlipTask)


def _samples(record: Record) -> tuple[str, str, str]:
    return record.identity.task, record.identity.variant, record.identity.dataset
