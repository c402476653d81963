"""What may be said of each score beside its interval: the ranks it may hold, and the probe that comes near it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from leaderboard.audit import PROTOCOL, reached
from leaderboard.frame import OWN, Row, latest, records_of
from leaderboard.ranks import Entrant, Rank, rank
from leaderboard.tally import Tally

Better = frozenset[tuple[str, str]]
"""Pairs of keys: the first record's method is surely better than the second's."""

_Z = 1.959964


def judged(cells: pd.DataFrame, tallies: Mapping[str, Tally]) -> tuple[pd.DataFrame, Better]:
    """Return the table of records with probe warnings, rank intervals and letters filled in, and who beats whom.

    Methods of one protocol are ranked among each other, self-reported and flagged submissions each among their own.
    Of equal cells only the latest has a rank.
    """
    near = reached(cells)
    ranks, how, better = _ranks(cells, tallies)
    key = cells["key"].where(cells.index.isin(latest(cells).index), "")
    held = [ranks.get(str(name)) for name in key]
    filled = cells.assign(
        probe=key.map(lambda name: near.get(name, "")),
        rank_best=pd.array([r.best if r else None for r in held], dtype="Int64"),
        rank_worst=pd.array([r.worst if r else None for r in held], dtype="Int64"),
        letters=[r.letters if r else "" for r in held],
        ranked=key.map(lambda name: how.get(name, "")),
    )
    return filled, better


def _ranks(cells: pd.DataFrame, tallies: Mapping[str, Tally]) -> tuple[dict[str, Rank], dict[str, str], Better]:
    kept = latest(cells)
    kept = kept[(kept["role"] == "method") & (kept["state"] == "ok")].dropna(subset=["value", "low", "high"])
    protocols: dict[tuple[Any, ...], list[Row]] = {}
    for row in records_of(kept):
        apart = "" if row["standing"] in OWN else row["standing"]
        protocols.setdefault((*(row[name] for name in PROTOCOL), row["metric"], apart), []).append(row)
    ranks: dict[str, Rank] = {}
    how: dict[str, str] = {}
    better: set[tuple[str, str]] = set()
    for rows in protocols.values():
        keys = [str(row["key"]) for row in rows]
        ranking = rank([_entrant(row, tallies.get(str(row["key"]))) for row in rows])
        ranks |= zip(keys, ranking.ranks, strict=True)
        how |= dict.fromkeys(keys, ranking.how)
        better |= {(a, b) for i, a in enumerate(keys) for j, b in enumerate(keys) if ranking.better[i, j]}
    return ranks, how, frozenset(better)


def _entrant(row: Row, tally: Tally | None) -> Entrant:
    sign = 1 if row["direction"] == "higher" else -1
    error = (row["high"] - row["low"]) / (2 * _Z)
    if tally is None or row["unit"] != "%" or sign < 0:
        return Entrant(sign * row["value"], error)
    return Entrant(row["value"], error, tally.groups, tally.samples)
