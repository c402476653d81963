"""What stands below a table: how intervals and ranks were made, what the marks mean, which rows are missing and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from leaderboard.caution import MARK
from leaderboard.frame import Row
from leaderboard.names import SPLITS, title
from leaderboard.paper import ASSUMPTION
from leaderboard.tables import ResultTable
from leaderboard.views import FLAG, brief

Machines = Mapping[str, str]
"""Fingerprint -> the letter that stands for it."""


def result_notes(table: ResultTable, rows: list[Row], machines: Machines) -> tuple[str, ...]:
    """Return the notes of a result table, what bears on every row first."""
    notes = []
    if table.paper_table:
        notes.append(ASSUMPTION)
        notes += sorted({f"* {row['paper_note']}." for row in rows if row["paper_note"]})
        if any(row["modality"] == "fused-equal" for row in rows):
            notes.append(
                "The paper concatenates without weights; its fused figures stand beside our equal weights "
                "and beside weights chosen on training folds."
            )
    notes += [note for split in table.splits for note in _interval_note(split, rows)]
    notes += _rank_notes(table, rows) + _warnings(table, rows) + _reasons(table, rows)
    if table.superseded:
        notes.append(
            f"{table.superseded} earlier records of these cells differ in parameters, seed or machine; "
            "the latest is shown, all are in records.csv."
        )
    if len(table.fingerprints) > 1:
        letters = ", ".join(machines[f] for f in table.fingerprints)
        notes.append(f"Speeds were taken on different machines ({letters}) and do not compare.")
    timed = [row["predict_low_us"] is not None for row in rows if row["predict_us"] is not None]
    if len(set(timed)) > 1:
        notes.append(
            f"Speeds do not compare: {sum(timed)} of {len(timed)} were taken apart by `vtbench time`, a sample a call, "
            "the others during the run, in batches."
        )
    notes.append(f"Dataset {table.dataset}, content {table.dataset_hash[:12]}; protocol {table.protocol_version}.")
    return tuple(notes)


def _interval_note(split: str, rows: list[Row]) -> list[str]:
    """Return how a split's intervals were made, the commonest way first, with the number of rows where ways differ."""
    ways = Counter(row[f"{split}_interval"] for row in rows if row[f"{split}_interval"])
    if not ways:
        return []
    counts = sorted({int(row[f"{split}_groups"]) for row in rows if row[f"{split}_interval"]})
    groups = f"{counts[0]}" if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
    said = [
        way if len(ways) == 1 else f"{way} ({count} row{'s' if count > 1 else ''})" for way, count in ways.most_common()
    ]
    return [f"95 % intervals, {title(SPLITS, split)}, {groups} groups: {'; '.join(said)}."]


def _rank_notes(table: ResultTable, rows: list[Row]) -> list[str]:
    ways: dict[str, list[str]] = {}
    for split in table.splits:
        for way in sorted({row[f"{split}_ranked"] for row in rows if row[f"{split}_ranked"]}):
            ways.setdefault(way, []).append(title(SPLITS, split))
    return [
        f"Ranks, {', '.join(splits)}: those that a method may hold, all of them together with 95 % confidence; "
        f"methods that share a letter are tied ({way})."
        for way, splits in ways.items()
    ]


def _warnings(table: ResultTable, rows: list[Row]) -> list[str]:
    """Return what the marks beside scores and intervals mean, each once, with the splits it is said of."""
    said: dict[str, list[str]] = {}
    for split in table.splits:
        for field, mark in (("probe", FLAG), ("coverage", MARK)):
            for text in dict.fromkeys(row[f"{split}_{field}"] for row in rows if row[f"{split}_{field}"]):
                said.setdefault(f"{mark} {text}", []).append(title(SPLITS, split))
    return [f"{text} ({', '.join(dict.fromkeys(splits))})." for text, splits in said.items()]


def _reasons(table: ResultTable, rows: list[Row]) -> list[str]:
    counts: dict[tuple[str, str], int] = {}
    for row in rows:
        for split in table.splits:
            state, reason = row[f"{split}_state"], row[f"{split}_reason"]
            if state not in (None, "ok"):
                counts[state, reason] = counts.get((state, reason), 0) + 1
    return [f"{state.capitalize()} ({count}): {brief(reason)}" for (state, reason), count in counts.items()]
