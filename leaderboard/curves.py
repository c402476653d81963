"""The two curves of the board, as tables: accuracy against unknown pose, and error against speed."""

from __future__ import annotations

import re

import pandas as pd

from leaderboard.frame import latest

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
    "key",
]
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


def speed_table(cells: pd.DataFrame) -> pd.DataFrame:
    """Return error beside microseconds a sample, machine by machine: rows of two fingerprints are never compared.

    `total_us` is features plus method; `error` is 100 - accuracy in percent, or the value itself where lower is better.
    """
    kept = cells[(cells["role"] == "method") & (cells["state"] == "ok")].dropna(subset=["value", "predict_us"])
    higher = kept["direction"] == "higher"
    return (
        kept.assign(
            error=kept["value"].where(~higher, 100 - kept["value"]),
            error_low=kept["low"].where(~higher, 100 - kept["high"]),
            error_high=kept["high"].where(~higher, 100 - kept["low"]),
        )
        .reindex(columns=SPEED_COLUMNS)
        .sort_values(["task", "variant", "dataset_hash", "split", "fingerprint"], kind="stable")
        .reset_index(drop=True)
    )
