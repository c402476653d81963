"""Records -> one long table, a row a record: what every other table is made from, and `records.csv`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pandas as pd

from leaderboard.caution import coverage_warning
from leaderboard.names import METHODS, MODALITIES, ROLES, SPLITS, VARIANTS, fed_with, order
from leaderboard.record import Metric, Record, canonical_json
from leaderboard.submission import STATUSES

CELL = [
    "task",
    "protocol_version",
    "variant",
    "kind",
    "dataset_hash",
    "split",
    "role",
    "modality",
    "method",
    "standing",
]
OWN = ("", "verified")
"""Standings that may be best of a protocol; self-reported and flagged results stand apart."""
COLUMNS = [
    "key",
    "task",
    "protocol_version",
    "variant",
    "kind",
    "dataset",
    "dataset_hash",
    "split",
    "role",
    "modality",
    "method",
    "params",
    "seed",
    "standing",
    "submission",
    "state",
    "reason",
    "metric",
    "unit",
    "direction",
    "value",
    "low",
    "high",
    "interval",
    "n",
    "groups",
    "coverage",
    "probe",
    "rank_best",
    "rank_worst",
    "letters",
    "ranked",
    "predict_us",
    "predict_low_us",
    "predict_high_us",
    "feature_us",
    "total_us",
    "fit_s",
    "threads",
    "batch",
    "law",
    "expected",
    "observed",
    "passed",
    "fingerprint",
    "version",
    "commit",
    "started",
]

_FLOATS = ["value", "low", "high", "predict_us", "predict_low_us", "predict_high_us", "feature_us", "total_us", "fit_s"]
_COUNTS = ["n", "groups", "rank_best", "rank_worst", "threads", "batch"]
_TEXTS = ["coverage", "probe", "letters", "ranked"]

Row = dict[str, Any]


def records_frame(records: Iterable[Record]) -> pd.DataFrame:
    """Return one row a record, in the board's order; fractions in percent, what a record lacks is missing.

    The first metric of a record is the one shown; `standing` is the status of a submission, empty for our own.
    `coverage` warns of an interval; `probe`, rank and letters are left to `judgement.judged`. `total_us` adds features
    to the method where both are known.
    """
    rows = [_row(record) for record in sorted(records, key=_order)]
    frame = pd.DataFrame(rows, columns=COLUMNS)
    return frame.astype(dict.fromkeys(_FLOATS, "float64") | dict.fromkeys(_COUNTS, "Int64") | {"passed": "boolean"})


def latest(cells: pd.DataFrame) -> pd.DataFrame:
    """Return one row for each cell: of records that differ only in parameters, seed or machine, the last started."""
    newest = cells.sort_values("started", kind="stable").drop_duplicates(CELL, keep="last")
    return cells.loc[newest.index.sort_values()]


def records_of(frame: pd.DataFrame) -> list[Row]:
    """Return the rows as dicts, what is missing as None."""
    return [
        {str(name): None if pd.isna(value) else value for name, value in row.items()}
        for row in frame.to_dict(orient="records")
    ]


def _order(record: Record) -> tuple[object, ...]:
    who = record.identity
    return (
        who.task,
        who.protocol_version,
        who.kind,
        order(VARIANTS, who.variant),
        who.dataset,
        who.dataset_hash,
        record.submission is not None and STATUSES.index(record.submission.status),
        ROLES.index(who.role),
        order(MODALITIES, fed_with(who.modality, who.params)),
        order(METHODS, who.method),
        order(SPLITS, who.split),
        record.key,
        record.provenance.started,
    )


def _row(record: Record) -> Row:
    who, where, cost = record.identity, record.provenance, record.timing
    row: Row = {name: getattr(who, name) for name in (*CELL, "dataset", "seed") if name in type(who).model_fields}
    row |= {
        **dict.fromkeys(_TEXTS, ""),
        "key": record.key,
        "modality": fed_with(who.modality, who.params),
        "params": canonical_json(who.params),
        "standing": record.submission.status if record.submission else "",
        "submission": record.submission.title if record.submission else "",
        "state": record.status.state,
        "reason": record.status.reason,
        "fingerprint": where.fingerprint,
        "version": where.version,
        "commit": where.commit,
        "started": where.started.isoformat(timespec="seconds"),
    }
    if record.metrics:
        row |= _metric(record.metrics[0])
    if cost is not None:
        parts = [part for part in (cost.feature_us_per_sample, cost.predict_us_per_sample) if part is not None]
        row |= {
            "predict_us": cost.predict_us_per_sample,
            "predict_low_us": cost.predict_low_us,
            "predict_high_us": cost.predict_high_us,
            "feature_us": cost.feature_us_per_sample,
            "total_us": sum(parts) if cost.predict_us_per_sample is not None else None,
            "fit_s": cost.fit_s,
            "threads": cost.threads,
            "batch": cost.batch,
        }
    if record.verdict is not None:
        row |= record.verdict.model_dump()
    return row


def _metric(metric: Metric) -> Row:
    scale, unit = (100.0, "%") if metric.unit == "fraction" else (1.0, metric.unit)
    return {
        "metric": metric.name,
        "unit": unit,
        "direction": metric.direction,
        "value": scale * metric.value,
        "low": None if metric.low is None else scale * metric.low,
        "high": None if metric.high is None else scale * metric.high,
        "interval": metric.interval,
        "n": metric.n,
        "groups": metric.groups,
        "coverage": coverage_warning(metric.interval, metric.groups, metric.value) if unit == "%" else "",
    }
