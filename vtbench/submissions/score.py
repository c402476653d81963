"""Models and predictions that were handed in -> records, one for each entry."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import Metric, Record, Status, write_record
from leaderboard.submission import Artifact, SubmissionEntry, SubmissionFile, plain_text, slug
from vtbench.data.files import make_folder, sha256_of
from vtbench.onnx_eval.evaluate import evaluate
from vtbench.onnx_eval.handed_in import Credit, Result, copies, record_of
from vtbench.onnx_eval.hidden import make
from vtbench.onnx_eval.sandbox import Limits
from vtbench.onnx_eval.tested import Tested, on_datasets, on_hidden
from vtbench.run.scoring import score
from vtbench.submissions.checking import check_folder
from vtbench.submissions.predictions import Predicted, class_indices, read_predictions_file
from vtbench.submissions.reading import artifact_path
from vtbench.tasks import TASKS

LONGEST_NAME = 80


@dataclass(frozen=True)
class Terms:
    """On what, and within which limits, something is evaluated."""

    variant: str | None = None
    split: str | None = None
    fold: str | None = None
    data: tuple[Path, ...] = ()
    hidden_seed: int | None = None
    samples: int | None = None
    seed: int = 0
    jobs: int = 1
    limits: Limits = Limits()  # noqa: RUF009  # frozen

    def tested(self, task: str) -> Tested:
        """The recordings; ValueError for names or data that are not there."""
        if self.hidden_seed is None:
            return on_datasets(task, self.variant, self.split, self.data, fold=self.fold, seed=self.seed)
        found = TASKS.get(task)
        hidden = make(found, self.variant or next(iter(found.variants)), self.hidden_seed, self.samples, self.jobs)
        return on_hidden(task, self.variant, self.split, hidden)


def evaluate_model(model: Path, task: str, name: str | None, terms: Terms, out: Path) -> Record:
    """Evaluate one model file.

    Raises:
        ValueError: no such file, a name that is no plain text, unknown task, variant or split, no data.
    """
    if not model.is_file():
        raise ValueError(f"{model}: expected an .onnx file or the folder of a submission, found neither")
    if name is not None:
        try:
            title = plain_text(name)
        except ValueError as error:
            raise ValueError(f"--name: {error}") from None
        if len(title) > LONGEST_NAME:
            raise ValueError(f"--name: expected {LONGEST_NAME} characters at most, got {len(title)}")
    else:
        title = slug(model.stem)
    credit = Credit(slug(title), title)
    return evaluate(model, terms.tested(task), credit, out, terms.limits)


def evaluate_folder(folder: Path, terms: Terms, out: Path) -> list[Record]:
    """Evaluate every entry of a submission; an entry that cannot be has a line on standard error, the others go on.

    Raises:
        ValueError: a submission.yaml that cannot be understood, or no entry that could be evaluated.
    """
    checked = check_folder(folder, terms.limits)
    if checked.file is None:
        more = f" (and {len(checked.problems) - 1} more)" if len(checked.problems) > 1 else ""
        raise ValueError(f"{folder}: {checked.problems[0]}{more}; `vtbench check {folder}` lists all")
    file, records, refused = checked.file, [], []
    for number, entry in enumerate(file.entries):
        path = artifact_path(folder, entry)
        hopeless = [p for p in checked.of_entry(number) if p.rule in ("S005", "S006", "S011")]
        try:
            if hopeless or isinstance(path, str):
                raise ValueError(str(hopeless[0] if hopeless else path))
            own = replace(
                terms,
                variant=terms.variant or entry.variant,
                split=terms.split or (entry.split if terms.hidden_seed is None else None),
                fold=terms.fold or (entry.fold if terms.hidden_seed is None else None),
            )
            records.append(_entry(path, file, entry, own, out))
        except ValueError as error:
            refused.append(str(error))
            print(f"vtbench: warning: {folder}: entry {number + 1} left out: {error}", file=sys.stderr)
    if not records:
        raise ValueError(f"{folder}: no entry could be evaluated: {refused[0]}")
    return records


def _entry(path: Path, file: SubmissionFile, entry: SubmissionEntry, terms: Terms, out: Path) -> Record:
    if entry.predictions is not None and terms.hidden_seed is not None:
        raise ValueError("predictions cannot be made of a hidden set that nobody has seen; hand in the model")
    tested = terms.tested(entry.task)
    more = {
        **{name: getattr(file, name) for name in ("authors", "licence", "link", "hardware", "trained_on")},
        "claimed": entry.claimed,
    }
    credit = Credit(file.id, file.title, more)
    if entry.model is not None:
        return evaluate(path, tested, credit, out, terms.limits)
    return score_predictions(path, tested, credit, out)


def score_predictions(path: Path, tested: Tested, credit: Credit, out: Path) -> Record:
    """Score a file of predictions and write the record; "self-reported", for nothing shows that a model made them."""
    make_folder(out)
    started = datetime.now(UTC)
    digest = sha256_of(path)
    predictions: Mapping[str, NDArray[Any]] | None = None
    metrics: tuple[Metric, ...] = ()
    status = Status(state="ok")
    try:
        predictions, truth = joined(read_predictions_file(path), tested)
        metrics = score(predictions, truth)
    except ValueError as error:
        status = Status(state="failed", reason=str(error))
    artifact = Artifact(sha256=digest, size_bytes=path.stat().st_size)
    others = copies(out, digest, credit.id)
    record = record_of(Result(status, metrics), tested, credit, artifact, started, "self-reported", others)
    write_record(out, record, predictions)
    return record


def joined(predicted: Predicted, tested: Tested) -> tuple[dict[str, NDArray[Any]], NDArray[np.int64]]:
    """Predictions in the order of the split's test parts, and the truth beside them; for other samples not looked at.

    Raises:
        ValueError: a tested sample without prediction, a label that is no class.
    """
    data, split = tested.data, tested.split
    labels = class_indices(predicted.labels, data.classes)
    rows = zip(predicted.ids.tolist(), predicted.folds.tolist(), strict=True)
    places = {name: at for at, name in enumerate(rows)}
    at, tests, folds, missing = [], [], [], []
    for number, fold in enumerate(split.folds):
        for sample in fold.test.tolist():
            name = str(data.ids[sample])
            place = places.get((name, fold.name), places.get((name, "")))
            if place is None:
                missing.append(f"{name} in {fold.name}")
                continue
            at.append(place)
            tests.append(sample)
            folds.append(number)
    if missing:
        given = str(predicted.ids[0])[:60]
        raise ValueError(
            f"{len(missing)} tested samples have no prediction, {missing[0]} first; the file begins with {given!r}"
        )
    rows_of = np.array(tests, np.int64)
    found = {
        "sample_id": data.ids[rows_of],
        "group": split.interval_groups[rows_of],
        "fold": np.array(folds, np.int32),
        "label": labels[at],
    }
    return found, data.labels[rows_of]
