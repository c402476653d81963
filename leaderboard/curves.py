"""The two curves of the board, as tables: accuracy against unknown pose, and error against speed."""

from __future__ import annotations

import re
from collections.abc import Iterable

import pandas as pd

from leaderboard.frame import OWN, Row, latest, records_of
from leaderboard.judgement import Better

CURVE = ["task", "protocol_version", "kind", "split"]
POSE_COLUMNS = [
    *CURVE,
    "variant",
    "jitter_mm",
    "role",
    "modality",
    "method",
    "value",
    "low",
    "high",
    "unit",
    "coverage",
    "probe",
    "state",
    "key",
]
SPEED_COLUMNS = [
    "task",
    "protocol_version",
    "variant",
    "kind",
    "dataset",
    "dataset_hash",
    "split",
    "fingerprint",
    "modality",
    "method",
    "error",
    "error_low",
    "error_high",
    "predict_us",
    "predict_low_us",
    "predict_high_us",
    "feature_us",
    "total_us",
    "unit",
    "coverage",
    "probe",
    "dominated_by",
    "key",
]
_TOGETHER = ["task", "protocol_version", "variant", "kind", "dataset_hash", "split", "fingerprint"]
_MILLIMETRES = re.compile(r"(\d+(?:\.\d+)?)\s*mm")


def pose_curve(cells: pd.DataFrame) -> pd.DataFrame:
    """Return accuracy by unknown shift: the scored records of pose tasks whose variant states millimetres."""
    kept = latest(cells)
    kept = kept[kept["task"].str.startswith("objects/pose/") & kept["role"].isin(["method", "upper-line"])]
    kept = kept[kept["state"] == "ok"].dropna(subset=["value"])
    jitter = kept["variant"].map(jitter_mm).astype(float)
    return kept.assign(jitter_mm=jitter).dropna(subset=["jitter_mm"]).reindex(columns=POSE_COLUMNS)


def jitter_mm(variant: str) -> float | None:
    """Return the millimetres in a variant's name (`jitter-4mm`), or None."""
    found = _MILLIMETRES.search(variant)
    return float(found.group(1)) if found else None


def speed_table(cells: pd.DataFrame, better: Better = frozenset()) -> pd.DataFrame:
    """Return error beside microseconds a sample, machine by machine: rows of two fingerprints are never compared.

    `total_us` is features plus method; `error` is 100 - accuracy in percent, or the value itself where lower is better.
    `dominated_by` is the key of a method that is faster and, by `better`, surely has fewer errors. Self-reported and
    flagged submissions are not in it.
    """
    kept = cells[(cells["role"] == "method") & (cells["state"] == "ok")].dropna(subset=["value", "predict_us"])
    kept = kept[kept["standing"].isin(OWN)]
    higher = kept["direction"] == "higher"
    table = (
        kept.assign(
            error=kept["value"].where(~higher, 100 - kept["value"]),
            error_low=kept["low"].where(~higher, 100 - kept["high"]),
            error_high=kept["high"].where(~higher, 100 - kept["low"]),
        )
        .reindex(columns=SPEED_COLUMNS)
        .sort_values(["task", "variant", "dataset_hash", "split", "fingerprint"], kind="stable")
        .reset_index(drop=True)
    )
    rows = records_of(table)
    groups: dict[tuple[object, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in _TOGETHER), []).append(row)
    beaten = {id(row): dominant(row, group, better, "total_us") for group in groups.values() for row in group}
    return table.assign(dominated_by=[beaten[id(row)] for row in rows])


def dominant(row: Row, rows: Iterable[Row], better: Better, time: str) -> str:
    """Return the key of the best of `rows` that is faster than `row` and surely better, or nothing.

    Where a time has an interval, the intervals must not touch; one taken apart and one taken during the run do not
    compare.
    """
    low = row["predict_low_us"] if time == "predict_us" and row["predict_low_us"] else row[time]
    found = [
        other
        for other in rows
        if (other["key"], row["key"]) in better
        and (other["predict_low_us"] is None) == (row["predict_low_us"] is None)
        and (other["predict_high_us"] if time == "predict_us" and other["predict_high_us"] else other[time]) < low
    ]
    return str(min(found, key=lambda other: other["error"])["key"]) if found else ""


def front(rows: Iterable[Row], time: str) -> list[Row]:
    """Return the Pareto front by the point estimates: from fast to slow, with fewer errors than all faster."""
    kept: list[Row] = []
    for row in sorted(rows, key=lambda row: (row[time], row["error"])):
        if not kept or row["error"] < kept[-1]["error"]:
            kept.append(row)
    return kept
