"""Timings of a run as rows, as a CSV beside the samples, and in the records that the board reads."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from leaderboard.record import Record, Timing, read_records, write_record
from vtbench.data.files import write_text
from vtbench.timing.schedule import Sample
from vtbench.timing.subject import Subject
from vtbench.timing.summary import Cost, cost, ratio_interval

CSV_FILE = "timings.csv"


def rows(subjects: Sequence[Subject], samples: Mapping[str, Sequence[Sample]]) -> list[dict[str, Any]]:
    """One row a subject, the control's second copy left out; microseconds a sample on one thread."""
    return [_row(subject, cost(samples[subject.slug])) for subject in subjects if subject.copy == "a"]


def _row(subject: Subject, found: Cost) -> dict[str, Any]:
    return {
        "what": subject.name,
        "kind": subject.kind,
        "us_one": found.one.value,
        "us_one_low": found.one.low,
        "us_one_high": found.one.high,
        "us_one_least": found.one.least,
        "us_one_p95": found.one.p95,
        "us_batch": found.many.value,
        "us_batch_low": found.many.low,
        "us_batch_high": found.many.high,
        "batch": found.large,
        "first_call_us": found.first_us,
        "import_s": found.import_s,
        "load_s": found.load_s,
        "peak_mb": found.peak_mb,
        "params": found.params,
        "macs": found.macs,
        "kb": None if found.bytes is None else found.bytes / 1000,
        "processes": found.processes,
    }


def control(subjects: Sequence[Subject], samples: Mapping[str, Sequence[Sample]]) -> dict[str, Any] | None:
    """The A/A control: one subject timed as if it were two; None where nothing was."""
    second = next((subject for subject in subjects if subject.copy == "b"), None)
    if second is None:
        return None
    first = next(s for s in subjects if (s.name, s.kind, s.copy) == (second.name, second.kind, "a"))
    a, b = (np.array([np.median(each["one_ns"]) for each in samples[s.slug]]) for s in (first, second))
    ratio, low, high = ratio_interval(a, b)
    return {"what": second.name, "ratio": ratio, "low": low, "high": high, "alike": low <= 1 <= high}


def write_csv(folder: Path, table: Sequence[Mapping[str, Any]]) -> Path:
    """The rows as a CSV in `folder`."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(table[0]))
    writer.writeheader()
    writer.writerows(table)
    write_text(folder / CSV_FILE, text.getvalue())
    return folder / CSV_FILE


def into_records(out: Path, subjects: Sequence[Subject], samples: Mapping[str, Sequence[Sample]]) -> int:
    """Put what was measured in place of the indicative timing of every record of the rows timed; how many there were.

    The time of features is replaced where all networks that feed a method were timed too.
    """
    records = {record.key: record for record in read_records(out)}
    changed = 0
    for subject in subjects:
        if subject.kind == "features" or subject.copy == "b":
            continue
        found = cost(samples[subject.slug])
        known = subject.features and all(samples.get(slug) for slug in subject.features)
        features = sum(cost(samples[slug]).one.value for slug in subject.features) if known else None
        split = records[subject.key].identity.split if subject.key in records else ""
        for record in (records[key] for key in subject.row if key in records):
            if record.timing is not None:
                write_record(out, _timed(record, found, features, split))
                changed += 1
    return changed


def _timed(record: Record, found: Cost, features: float | None, split: str) -> Record:
    assert record.timing is not None
    timing = Timing(
        threads=1,
        batch=1,
        fit_s=record.timing.fit_s,
        predict_us_per_sample=found.one.value,
        predict_low_us=found.one.low,
        predict_high_us=found.one.high,
        feature_us_per_sample=record.timing.feature_us_per_sample if features is None else features,
        peak_rss_mb=found.peak_mb,
        note=f"`vtbench time`: one sample a call, fitted on the first fold of the split {split}, median of "
        f"{found.processes} process medians and its 95 % interval; {found.many.value:.3g} us a sample in a batch of "
        f"{found.large}",
    )
    return record.model_copy(update={"timing": timing})
