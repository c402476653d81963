"""Simulated beside real: do methods rank alike on simulated and on real recordings of the same kind of task?

Tasks of one family (`texture/...`) with both kinds are laid side by side, method by method. Scores are never merged.
"""

from __future__ import annotations

from itertools import product
from math import atanh, sqrt, tanh

import pandas as pd
from scipy.stats import rankdata

from leaderboard.frame import OWN, Row, latest, records_of

SIDE = ["task", "variant", "dataset_hash", "split"]
LEAST = 4
"""Fewer methods in common have no rank correlation worth a number."""
COLUMNS = [
    "family",
    "modality",
    "method",
    *(f"{kind}_{name}" for kind in ("simulated", "real") for name in (*SIDE, "value", "low", "high", "rank", "key")),
    "methods",
    "rank_correlation",
    "rank_correlation_low",
    "rank_correlation_high",
]


def beside_table(cells: pd.DataFrame) -> pd.DataFrame:
    """Return one row a method that was scored on simulated and on real recordings of one family, with both ranks.

    Ranks count only the methods in common, 1 the best, ties share theirs; `rank_correlation` is Spearman's, with Bonett
    and Wright's 95 % interval, missing below four methods. Protocols that share fewer than two methods give no row.
    """
    kept = latest(cells)
    kept = kept[(kept["role"] == "method") & (kept["state"] == "ok") & kept["standing"].isin(OWN)]
    sides: dict[tuple[str, str], dict[tuple[str, ...], dict[tuple[str, str], Row]]] = {}
    for row in records_of(kept.dropna(subset=["value"])):
        family = str(row["task"]).split("/")[0]
        side = sides.setdefault((family, row["kind"]), {}).setdefault(tuple(row[name] for name in SIDE), {})
        side[row["modality"], row["method"]] = row
    rows: list[Row] = []
    for family in dict.fromkeys(name for name, _ in sides):
        for ours, theirs in product(*(sides.get((family, kind), {}).values() for kind in ("simulated", "real"))):
            rows += _side_by_side(family, ours, theirs)
    return pd.DataFrame(rows, columns=COLUMNS)


def _side_by_side(family: str, ours: dict[tuple[str, str], Row], theirs: dict[tuple[str, str], Row]) -> list[Row]:
    shared = [name for name in ours if name in theirs and ours[name]["metric"] == theirs[name]["metric"]]
    if len(shared) < 2:
        return []
    ranks = {}
    for kind, side in (("simulated", ours), ("real", theirs)):
        goodness = [side[n]["value"] * (1 if side[n]["direction"] == "higher" else -1) for n in shared]
        ranks[kind] = rankdata([-g for g in goodness])
    rho, low, high = rank_correlation(list(ranks["simulated"]), list(ranks["real"]))
    rows = []
    for at, name in enumerate(shared):
        row: Row = {"family": family, "modality": name[0], "method": name[1], "methods": len(shared)}
        for kind, side in (("simulated", ours), ("real", theirs)):
            row |= {f"{kind}_{field}": side[name][field] for field in (*SIDE, "value", "low", "high", "key")}
            row[f"{kind}_rank"] = float(ranks[kind][at])
        row |= {"rank_correlation": rho, "rank_correlation_low": low, "rank_correlation_high": high}
        rows.append(row)
    return rows


def rank_correlation(a: list[float], b: list[float]) -> tuple[float | None, float | None, float | None]:
    """Return Spearman's correlation of two lists of ranks with its 95 % interval; None where it says nothing.

    Source: Bonett and Wright, Psychometrika 65 (2000).
    """
    n = len(a)
    if n < LEAST or len(set(a)) == 1 or len(set(b)) == 1:
        return None, None, None
    mean = (n + 1) / 2
    x, y = [v - mean for v in a], [v - mean for v in b]
    r = sum(p * q for p, q in zip(x, y, strict=True)) / sqrt(sum(p * p for p in x) * sum(q * q for q in y))
    if abs(r) > 1 - 1e-12:
        return round(r), None, None
    half = 1.959964 * sqrt((1 + r * r / 2) / (n - 3))
    return r, tanh(atanh(r) - half), tanh(atanh(r) + half)
