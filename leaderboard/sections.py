"""Tables -> views: which columns a reader sees, in which words, and what stands in the notes below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pandas as pd

from leaderboard.frame import Row, records_of
from leaderboard.labels import beside, labels
from leaderboard.names import METHODS, MODALITIES, ROLES, SPLITS, VARIANTS, order, title
from leaderboard.notes import Machines, result_notes
from leaderboard.tables import ResultTable
from leaderboard.views import (
    NOT_RUN,
    Cell,
    Column,
    View,
    breaks_of,
    brief,
    microseconds,
    number,
    paled,
    rank_cell,
    score_cell,
    span,
)

RANK_HINT = "the ranks that a method may hold; letters join methods that are not told apart"
STANDINGS = {
    "verified": "a submission whose model ran here",
    "self-reported": "predictions that were handed in; that a model made them is the author's word",
    "flagged": "a submission that does not fit; its record says why",
    "unverified": "a submission whose model gave no score here; its record says why",
}
APART = {"self-reported": "self-reported submissions, apart", "flagged": "flagged submissions, apart"}


def standing_shown(status: str, scored: bool) -> str:
    """Return the standing to show beside a result: without a score nothing was verified."""
    return "unverified" if status == "verified" and not scored else status


def result_view(table: ResultTable, machines: Machines) -> View:
    """Return the view of a task's table or of one of the paper's."""
    rows = records_of(table.frame)
    paper = bool(table.paper_table)
    features = any(row["feature_us"] is not None for row in rows)
    mixed = len(table.fingerprints) > 1
    columns = [Column("Fed with"), Column("Method")]
    columns += [Column("Paper, %", True, "as published, with the Wilson interval at an assumed n")] if paper else []
    mine = "ours, " if paper else ""
    ranked = [split for split in table.splits if any(row[f"{split}_rank_worst"] not in (None, 1) for row in rows)]
    for split in table.splits:
        columns.append(Column(f"{mine}{title(SPLITS, split)}, {table.unit}"[:60].capitalize(), True))
        columns += [Column("Rank", True, RANK_HINT, smallest_first=True)] if split in ranked else []
    speed_hint = "of two machines, so not sortable" if mixed else "the method alone, one thread"
    columns += [Column("µs a sample", True, speed_hint, not mixed)]
    columns += [Column("µs, features", True, "what turns a frame into features", not mixed)] if features else []
    return View(
        id=f"t-{table.task}-{table.variant}-{table.dataset_hash[:8]}{table.apart and f'-{table.apart}'}".replace(
            "/", "-"
        ),
        title=_result_title(table),
        columns=tuple(columns),
        rows=paled([_result_row(row, table, ranked, machines if mixed else {}, features) for row in rows], 1),
        notes=result_notes(table, rows, machines),
        header=1,
        breaks=breaks_of([(row["role"], row["modality"]) for row in rows]),
        kind=table.kind,
    )


def _result_title(table: ResultTable) -> str:
    if table.paper_table:
        return beside(f"Table {table.paper_table} of the paper beside ours: {table.press} presses", table.label)
    return beside(f"Protocol {table.variant}", table.label) + (f": {APART[table.apart]}" if table.apart else "")


def _result_row(
    row: Row, table: ResultTable, ranked: Sequence[str], machines: Machines, features: bool
) -> tuple[Cell, ...]:
    upper = row["role"] == "upper-line"
    scored = any(row[f"{split}_state"] == "ok" for split in table.splits)
    standing = standing_shown(str(row["standing"] or ""), scored)
    cells = [
        Cell(title(MODALITIES, row["modality"]), hint="an upper line: no sensor gives this" if upper else ""),
        Cell(
            brief(row["submission"] or title(METHODS, row["method"]), 60),
            "upper line" if upper else "",
            badge=standing,
            hint=STANDINGS.get(standing, ""),
        ),
    ]
    if table.paper_table:
        reported = row["paper"]
        cells.append(
            Cell(
                number(reported, 2),
                span(row["paper_low"], row["paper_high"]),
                reported,
                hint=row["paper_note"] or "",
                tone="" if reported is not None else "muted",
                mark="*" if row["paper_note"] else "",
            )
        )
    for split in table.splits:
        cells.append(score_cell(row, f"{split}_", table.unit))
        cells += [rank_cell(row, f"{split}_")] if split in ranked else []
    letter = machines.get(row["fingerprint"] or "", "")
    costs = [row["predict_us"], *([row["feature_us"]] if features else [])]
    cells += [Cell(microseconds(us), letter if us is not None else "", us, tone="" if us else "muted") for us in costs]
    return tuple(cells)


def beside_views(beside: pd.DataFrame) -> list[View]:
    """Return a view for each simulated protocol beside each real one of its family."""
    pairs = [
        f"{kind}_{name}" for kind in ("simulated", "real") for name in ("task", "variant", "dataset_hash", "split")
    ]
    return [beside_view(records_of(part)) for _, part in beside.groupby(pairs, sort=False)] if len(beside) else []


def beside_view(rows: list[Row]) -> View:
    """Return the view of one pair of protocols: each method's rank on simulated and on real recordings."""
    first = rows[0]
    sides = {kind: [first[f"{kind}_{name}"] for name in ("task", "variant", "split")] for kind in ("simulated", "real")}
    rho, low, high = (first[f"rank_correlation{end}"] for end in ("", "_low", "_high"))
    around = f" (95 % {low:.2f} to {high:.2f})" if low is not None else ""
    count = first["methods"]
    correlation = (
        f"Spearman's rank correlation over {count} methods: {rho:.2f}{around}."
        if rho is not None
        else f"{count} methods in common: too few, or too tied, for a rank correlation."
    )
    columns = [Column("Fed with"), Column("Method")]
    for kind in ("simulated", "real"):
        columns += [Column(f"{kind.capitalize()}, %", True), Column("Rank", True, smallest_first=True)]
    return View(
        id="beside",
        title=" beside ".join(f"{kind} {t}, {v}, {title(SPLITS, s)}" for kind, (t, v, s) in sides.items()),
        columns=tuple(columns),
        rows=paled(
            [
                (
                    Cell(title(MODALITIES, row["modality"])),
                    Cell(title(METHODS, row["method"])),
                    *(cell for kind in ("simulated", "real") for cell in _beside_cells(row, kind)),
                )
                for row in rows
            ],
            1,
        ),
        notes=(correlation, "Ranks count the methods in common only; the scores themselves do not compare."),
        header=1,
    )


def _beside_cells(row: Row, kind: str) -> tuple[Cell, Cell]:
    value, low, high, rank, key = (row[f"{kind}_{name}"] for name in ("value", "low", "high", "rank", "key"))
    return Cell(number(value), span(low, high), value, key=str(key)), Cell(f"{rank:g}", sort=rank)


def pose_view(curve: pd.DataFrame) -> View:
    """Return the figures behind a pose curve: a row for each split, feed and method, a column for each shift."""
    lines: dict[tuple[str, str, str, str], dict[float, Row]] = {}
    for row in sorted(records_of(curve), key=_curve_order):
        name = (row["split"], row["role"], row["modality"], row["method"])
        lines.setdefault(name, {})[row["jitter_mm"]] = row
    shifts = sorted({shift for line in lines.values() for shift in line})
    rows = [
        (
            Cell(title(SPLITS, split)),
            Cell(title(MODALITIES, modality)),
            Cell(title(METHODS, method), "upper line" if role == "upper-line" else ""),
            *(score_cell(line.get(shift, {})) for shift in shifts),
        )
        for (split, role, modality, method), line in lines.items()
    ]
    return View(
        id="pose",
        title="Accuracy by unknown shift",
        columns=(
            *(Column(name) for name in ("Split", "Fed with", "Method")),
            *(Column(f"{shift:g} mm, %", True) for shift in shifts),
        ),
        rows=paled(rows, 2),
        header=2,
        breaks=breaks_of([name[:3] for name in lines]),
    )


def _curve_order(row: Row) -> tuple[object, ...]:
    return (
        order(SPLITS, row["split"]),
        ROLES.index(row["role"]),
        order(MODALITIES, row["modality"]),
        order(METHODS, row["method"]),
    )


def probe_views(probes: pd.DataFrame) -> list[View]:
    """Return a table a task: a row for each protocol, each probe's strongest method, and the best method beside."""
    return [_probe_view(str(task), records_of(part)) for task, part in probes.groupby("task", sort=False)]


def _probe_view(task: str, rows: list[Row]) -> View:
    names = sorted({row["modality"] for row in rows}, key=lambda name: order(MODALITIES, name))
    protocols: dict[tuple[Any, ...], dict[str, Row]] = {}
    for row in sorted(rows, key=lambda row: (order(VARIANTS, row["variant"]), order(SPLITS, row["split"]))):
        where = tuple(row[name] for name in ("variant", "split", "kind", "dataset_hash", "protocol_version"))
        line = protocols.setdefault(where, {})
        rival = line.setdefault(row["modality"], row)
        if row["value"] is not None and (rival["value"] is None or row["value"] > rival["value"]):
            line[row["modality"]] = row
    unit = next((row["unit"] for row in rows if row["unit"]), "%")
    first = [next(iter(line.values())) for line in protocols.values()]
    same = [(row["variant"], row["split"], row["kind"]) for row in first]
    named = labels(same, [row["dataset"] for row in first], [row["dataset_hash"] for row in first])
    lines = [
        (
            Cell(beside(variant, label)),
            Cell(title(SPLITS, split)),
            *(_probe_cell(line.get(name, {})) for name in names),
            _best_cell(next(iter(line.values()))),
        )
        for ((variant, split, *_), line), label in zip(protocols.items(), named, strict=True)
    ]
    return View(
        id="probes",
        title=task,
        columns=(
            Column("Variant"),
            Column("Split"),
            *(Column(f"{title(MODALITIES, name).capitalize()}, {unit}", True) for name in names),
            Column(f"Best method, {unit}", True),
        ),
        rows=paled(lines, 1),
        header=1,
    )


def _probe_cell(row: Row) -> Cell:
    cell = score_cell(row, unit=row.get("unit") or "%")
    hint = f"{title(METHODS, row['method'])}: {cell.hint}" if row else cell.hint
    if row.get("warning"):
        return replace(cell, text=f"⚠ {cell.text}", hint=f"comes near the best method; {hint}", tone="bad")
    return replace(cell, hint=hint)


def _best_cell(row: Row) -> Cell:
    if row["best_value"] is None:
        return Cell(NOT_RUN, tone="muted")
    who = f"{title(METHODS, row['best_method'])}, {title(MODALITIES, row['best_modality'])}"
    return Cell(number(row["best_value"]), span(row["best_low"], row["best_high"]), row["best_value"], hint=who)


def laws_view(laws: pd.DataFrame) -> View:
    """Return, for each law and what the methods are fed, how many methods hold and what was seen."""
    grouped: dict[tuple[Any, ...], list[Row]] = {}
    for row in records_of(laws):
        where = tuple(row[name] for name in ("task", "variant", "dataset_hash", "split", "modality"))
        grouped.setdefault(where, []).append(row)
    names = ("Law", "Task", "Split", "Fed with", "Holds for", "Expected", "Seen")
    return View(
        id="laws",
        title="Laws",
        columns=tuple(Column(name, wrap=name in ("Law", "Holds for", "Seen")) for name in names),
        header=3,
        rows=paled([_law_row(rows) for rows in grouped.values()], 3),
    )


def _law_row(rows: list[Row]) -> tuple[Cell, ...]:
    first = next((row for row in rows if row["law"]), rows[0])
    judged = [row for row in rows if row["passed"] is not None]
    broken = [row for row in judged if not row["passed"]]
    count = f"{len(judged) - len(broken)} of {len(rows)} methods"
    whose = ", ".join(title(METHODS, row["method"]) for row in broken)
    seen = list(dict.fromkeys(row["observed"] for row in judged))
    whole = len(judged) == len(rows) and not broken
    return (
        Cell(first["law"] or "not judged"),
        Cell(first["task"]),
        Cell(title(SPLITS, first["split"])),
        Cell(title(MODALITIES, first["modality"])),
        Cell(count, f"broken by {whose}" if broken else "", tone="good" if whole else "bad"),
        Cell(first["expected"] or ""),
        Cell(", ".join(seen[:6]) + (" …" if len(seen) > 6 else "")),
    )
