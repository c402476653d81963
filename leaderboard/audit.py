"""What a reader must know before believing a table: probes, laws, protocols too easy to rank, rows that are missing."""

from __future__ import annotations

from typing import Any

import pandas as pd

from leaderboard.frame import OWN, Row, latest, records_of
from leaderboard.names import METHODS, MODALITIES, SPLITS, title

PROBE_MARGIN = 5.0
"""A probe this close to the best method, in percentage points, or with an overlapping interval, is a warning."""
LEAST_GROUPS = 3
"""With fewer, a 95 % interval holds nearly every score: that two of them overlap says nothing."""
TOO_EASY = 99.0
"""Above this accuracy, in percent, for best and worst method alike, a protocol ranks nothing."""

PROTOCOL = ["task", "protocol_version", "variant", "kind", "dataset", "dataset_hash", "split"]
PROBE_COLUMNS = [
    *PROTOCOL,
    "modality",
    "method",
    "value",
    "low",
    "high",
    "unit",
    "state",
    "reason",
    "key",
    "best_modality",
    "best_method",
    "best_value",
    "best_low",
    "best_high",
    "margin",
    "warning",
]
LAW_COLUMNS = [*PROTOCOL, "modality", "method", "law", "expected", "observed", "passed", "state", "reason", "key"]


def probes_table(cells: pd.DataFrame, margin: float = PROBE_MARGIN) -> pd.DataFrame:
    """Return one row a probe beside the best method of the same protocol; `warning` where the probe comes near.

    Near means within `margin` percentage points of the best method's score, better than it, or with an overlapping
    interval, where both have three groups or more: then the score may rest on what the probe sees, and not on touch.
    """
    kept = latest(cells)
    best = _best_methods(kept)
    rows = []
    for probe in records_of(kept[kept["role"] == "probe"]):
        row = probe | {"margin": margin, "warning": False}
        champion = best.get(tuple(probe[name] for name in PROTOCOL))
        if champion is not None:
            row |= {f"best_{name}": champion[name] for name in ("modality", "method", "value", "low", "high")}
            row["warning"] = probe["value"] is not None and _near(probe, champion, margin)
        rows.append(row)
    return pd.DataFrame(rows, columns=PROBE_COLUMNS)


def _best_methods(kept: pd.DataFrame) -> dict[tuple[Any, ...], Row]:
    best: dict[tuple[Any, ...], Row] = {}
    scored = kept[(kept["role"] == "method") & (kept["state"] == "ok") & kept["standing"].isin(OWN)]
    for row in records_of(scored.dropna(subset=["value"])):
        sign = 1 if row["direction"] == "higher" else -1
        rival = best.setdefault(tuple(row[name] for name in PROTOCOL), row)
        if sign * row["value"] > sign * rival["value"]:
            best[tuple(row[name] for name in PROTOCOL)] = row
    return best


def _near(probe: Row, best: Row, margin: float) -> bool:
    higher = best["direction"] == "higher"
    ahead = probe["value"] - best["value"] if higher else best["value"] - probe["value"]
    if ahead >= (-margin if best["unit"] == "%" else 0):
        return True
    if probe["high"] is None or best["low"] is None or min(probe["groups"], best["groups"]) < LEAST_GROUPS:
        return False
    return bool(probe["high"] >= best["low"] if higher else probe["low"] <= best["high"])


def reached(cells: pd.DataFrame, margin: float = PROBE_MARGIN) -> dict[str, str]:
    """Return, for the key of each method's record whose score a probe of its protocol comes near, what to say of it.

    Near as in `probes_table`, but to this score rather than the best; of several probes the strongest is named.
    """
    kept = latest(cells)
    kept = kept[kept["state"] == "ok"].dropna(subset=["value"])
    probes: dict[tuple[Any, ...], list[Row]] = {}
    for row in records_of(kept[kept["role"] == "probe"]):
        probes.setdefault(tuple(row[name] for name in PROTOCOL), []).append(row)
    said = {}
    for row in records_of(kept[kept["role"] == "method"]):
        rivals = [p for p in probes.get(tuple(row[name] for name in PROTOCOL), []) if p["metric"] == row["metric"]]
        near = [probe for probe in rivals if _near(probe, row, margin)]
        if near:
            sign = 1 if row["direction"] == "higher" else -1
            said[str(row["key"])] = _reached_by(max(near, key=lambda probe: sign * probe["value"]))
    return said


def _reached_by(probe: Row) -> str:
    name = f"“{title(MODALITIES, probe['modality'])}” ({title(METHODS, probe['method'])})"
    return f"a probe comes near: {name} reaches {probe['value']:.1f} {probe['unit']}"


def probe_warning(row: Row) -> str:
    """Return the sentence that stands wherever the score of a warned protocol is shown."""
    unit = row["unit"]
    close = unit == "%" and row["value"] >= row["best_value"] - row["margin"]
    return (
        f"{row['task']}, {row['variant']}, {title(SPLITS, row['split'])}: the probe "
        f"“{title(MODALITIES, row['modality'])}” ({title(METHODS, row['method'])}) reaches {row['value']:.1f} {unit}, "
        f"the best method {row['best_value']:.1f} {unit}{'' if close else ', with overlapping intervals'}. "
        "What the probe sees may explain the score."
    )


def laws_table(cells: pd.DataFrame) -> pd.DataFrame:
    """Return one row a law and method: what must be, what was seen, whether it holds (missing where it did not run)."""
    kept = latest(cells)
    return kept[kept["role"] == "law"].reindex(columns=LAW_COLUMNS).reset_index(drop=True)


def too_easy(cells: pd.DataFrame, threshold: float = TOO_EASY) -> list[str]:
    """Return a sentence for each protocol in which best and worst method both exceed `threshold` percent.

    Methods are compared within a modality; two or more are needed. Probes, laws and upper lines do not count.
    """
    kept = latest(cells)
    kept = kept[(kept["role"] == "method") & (kept["state"] == "ok") & (kept["unit"] == "%")].dropna(subset=["value"])
    kept = kept[kept["standing"].isin(OWN)]
    sentences = []
    for block, rows in kept.groupby(PROTOCOL, sort=False):
        assert isinstance(block, tuple)
        easy = []
        for modality, values in rows.groupby("modality", sort=False)["value"]:
            if len(values) > 1 and values.min() > threshold:
                easy.append((title(MODALITIES, str(modality)), values.min(), values.max()))
        if easy:
            fed = "; ".join(f"{name} {low:.1f} to {high:.1f} %" for name, low, high in easy)
            sentences.append(
                f"{block[0]}, {block[2]}, {title(SPLITS, str(block[6]))}: too easy to rank the methods, "
                f"the best and the worst both exceed {threshold:g} % ({fed})."
            )
    return sentences


def missing(cells: pd.DataFrame) -> list[str]:
    """Return a sentence for each reason why rows are without a result, with their number."""
    gone = cells[cells["state"] != "ok"]
    return [
        f"{task}: {len(rows)} {'rows' if len(rows) > 1 else 'row'} {state}: {reason}"
        for (task, state, reason), rows in gone.groupby(["task", "state", "reason"], sort=False)
    ]
