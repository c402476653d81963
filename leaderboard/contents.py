"""Everything that a board says, gathered once: tables, curves, and what must be said beside them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import product
from string import ascii_uppercase

import pandas as pd

from leaderboard.audit import laws_table, missing, probe_warning, probes_table, too_easy
from leaderboard.counterparts import beside_table
from leaderboard.curves import CURVE, pose_curve, speed_table
from leaderboard.frame import Row, records_frame, records_of
from leaderboard.judgement import Better, judged
from leaderboard.names import METHODS, MODALITIES, title
from leaderboard.record import Record
from leaderboard.slip_tables import SlipBlock, slip_blocks, verdicts
from leaderboard.studies import study_levels, study_rows
from leaderboard.tables import ResultTable, paper_tables, task_tables
from leaderboard.tally import Tallies
from leaderboard.views import brief


@dataclass(frozen=True)
class Notice:
    """A sentence that belongs above the tables: a broken law, a near probe, a protocol too easy, rows missing."""

    kind: str
    text: str


@dataclass(frozen=True, eq=False)
class TaskGroup:
    """The tables of one task, its pose curve, and the rows of a study; both are empty for most."""

    task: str
    kind: str
    tables: tuple[ResultTable, ...]
    curve: pd.DataFrame
    study: tuple[Row, ...] = ()


@dataclass(frozen=True, eq=False)
class BoardTables:
    """The tables of one board. `machines` gives each machine fingerprint the letter that tables show."""

    cells: pd.DataFrame
    papers: tuple[ResultTable, ...]
    tasks: tuple[ResultTable, ...]
    probes: pd.DataFrame
    laws: pd.DataFrame
    pose: pd.DataFrame
    speed: pd.DataFrame
    notices: tuple[Notice, ...]
    machines: dict[str, str]
    slips: tuple[SlipBlock, ...] = ()
    better: Better = frozenset()
    beside: pd.DataFrame = field(default_factory=pd.DataFrame)

    @property
    def groups(self) -> list[TaskGroup]:
        """The tables by task; where shifts or levels make a curve, it takes the place of their tables."""
        grouped: dict[tuple[str, int, str], list[ResultTable]] = {}
        for table in self.tasks:
            grouped.setdefault((table.task, table.protocol_version, table.kind), []).append(table)
        return [self._group(name, group) for name, group in grouped.items()]

    def _group(self, name: tuple[str, int, str], group: list[ResultTable]) -> TaskGroup:
        if levels := study_levels(rows := study_rows(self.cells, name[0], name[2])):
            left = tuple(table for table in group if table.variant not in levels)
            return TaskGroup(name[0], name[2], left, self.pose.iloc[:0], tuple(rows))
        curve = self.pose[(self.pose[CURVE[:3]] == list(name)).all(axis=1)]
        if curve["jitter_mm"].nunique() < 2:
            return TaskGroup(name[0], name[2], tuple(group), curve.iloc[:0])
        shifts = set(curve["variant"])
        return TaskGroup(name[0], name[2], tuple(table for table in group if table.variant not in shifts), curve)


def board_tables(
    records: Iterable[Record], problems: Sequence[str] = (), tallies: Tallies | None = None
) -> BoardTables:
    """Return all tables of the records; `problems` are lines of `scan_records` about files that could not be read.

    With `tallies`, by key, methods are ranked by their differences on the same samples, else by their intervals.
    """
    records = list(records)
    cells, better = judged(records_frame(records), tallies or {})
    slips = slip_blocks(records)
    probes, laws = probes_table(cells), laws_table(cells)
    return BoardTables(
        cells=cells,
        papers=tuple(paper_tables(cells)),
        tasks=tuple(task_tables(cells)),
        probes=probes,
        laws=laws,
        pose=pose_curve(cells),
        speed=speed_table(cells, better),
        notices=(*_notices(cells, probes, laws, problems), *_slip_notices(slips)),
        machines=dict(zip(dict.fromkeys(cells["fingerprint"]), _letters(), strict=False)),
        slips=slips,
        better=better,
        beside=beside_table(cells),
    )


def _slip_notices(blocks: Sequence[SlipBlock]) -> Iterable[Notice]:
    for block in blocks:
        for sentence in verdicts(block):
            yield Notice("beside the baseline", sentence)


def _notices(
    cells: pd.DataFrame, probes: pd.DataFrame, laws: pd.DataFrame, problems: Sequence[str]
) -> Iterable[Notice]:
    for law in records_of(laws):
        if law["passed"] is False:
            who = f"{title(METHODS, law['method'])} on {title(MODALITIES, law['modality'])}"
            yield Notice(
                "law broken",
                f"{law['task']}, {law['variant']}: {law['law']}; {who}: {law['observed']}, expected {law['expected']}.",
            )
    for row in _strongest_warned(probes):
        yield Notice("probe near", probe_warning(row))
    for sentence in too_easy(cells):
        yield Notice("too easy", sentence)
    for row in records_of(cells[cells["standing"] == "flagged"].drop_duplicates(["task", "method"])):
        yield Notice("flagged", f"{row['task']}: the submission {row['submission']} is flagged and shown apart.")
    for sentence in missing(cells):
        yield Notice("missing", brief(sentence, 400))
    for problem in problems:
        yield Notice("unreadable", brief(problem, 400))


def _strongest_warned(probes: pd.DataFrame) -> list[dict[str, object]]:
    """Return one row for each probe and protocol that warns: its strongest method."""
    where = ["task", "protocol_version", "variant", "kind", "dataset_hash", "split", "modality"]
    warned = probes[probes["warning"].astype(bool)]
    strongest = warned.sort_values("value", ascending=False, kind="stable").drop_duplicates(where)
    return records_of(warned.loc[strongest.index.sort_values()])


def _letters() -> Iterable[str]:
    yield from ascii_uppercase
    yield from ("".join(pair) for pair in product(ascii_uppercase, repeat=2))
