"""Records -> a folder: one offline HTML page, the same tables as Markdown, and a CSV file for each."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import pandas as pd

from leaderboard._files import write_atomic
from leaderboard.contents import BoardTables, board_tables
from leaderboard.page import render_page
from leaderboard.record import Record
from leaderboard.sections import beside_views, laws_view, pose_view, probe_views, result_view
from leaderboard.slip_tables import metrics_frame
from leaderboard.slip_views import slip_views, table_iv
from leaderboard.studies import study_views
from leaderboard.tally import Tallies
from leaderboard.text import escape_markdown, markdown_table

TITLE = "vtbench: touch and vision, scored on the same terms"
SIMULATED = (
    "A simulated score is no evidence about the real sensor. The paper's figures, simulated and real recordings stand "
    "side by side and are never merged."
)


@dataclass(frozen=True)
class BoardFiles:
    """The files of a board that was written."""

    html: Path
    markdown: Path
    csv: list[Path]


def build_board(
    records: Iterable[Record],
    out_dir: Path,
    *,
    title: str = TITLE,
    problems: Sequence[str] = (),
    generated: datetime | None = None,
    tallies: Tallies | None = None,
) -> BoardFiles:
    """Write `index.html`, `board.md` and `csv/*.csv` under `out_dir` and return their paths.

    `problems` are the lines of `scan_records` about files that could not be read: the page lists them. `generated` is
    the date on the page, now by default. With `tallies` (`tally.read_tallies`) ranks come from paired differences.
    OSError when the folder cannot be written.
    """
    kept = distinct(records)
    tables = board_tables(kept, problems, tallies)
    when = generated or datetime.now(UTC)
    out_dir = Path(out_dir)
    (out_dir / "csv").mkdir(parents=True, exist_ok=True)
    files = BoardFiles(out_dir / "index.html", out_dir / "board.md", [])
    for name, frame in csv_tables(tables).items():
        files.csv.append(out_dir / "csv" / f"{name}.csv")
        write_atomic(files.csv[-1], harmless(frame).to_csv(index=False, lineterminator="\n").encode())
    write_atomic(files.markdown, render_markdown(tables, title, when).encode())
    write_atomic(files.html, render_page(kept, tables, title, when).encode())
    return files


def distinct(records: Iterable[Record]) -> list[Record]:
    """Return the records in order, of those with equal key and machine only the last started."""
    kept: dict[tuple[str, str], Record] = {}
    for record in records:
        name = (record.key, record.provenance.fingerprint)
        if name not in kept or record.provenance.started >= kept[name].provenance.started:
            kept[name] = record
    return list(kept.values())


def render_markdown(tables: BoardTables, title: str, generated: datetime) -> str:
    """Return the tables, what must be said beside them, and their notes, as Markdown without any HTML of a record."""
    parts = [f"# {escape_markdown(title)}\n", f"{generated:%Y-%m-%d}. {SIMULATED}\n"]
    if tables.notices:
        parts.append("".join(f"- **{n.kind}**: {escape_markdown(n.text)}\n" for n in tables.notices))
    if tables.papers or any(table_iv(block) for block in tables.slips):
        parts.append("## The paper's tables\n")
        parts += [markdown_table(result_view(table, tables.machines)) for table in tables.papers]
    parts += [markdown_table(view) for block in tables.slips if (view := table_iv(block)) is not None]
    for group in tables.groups:
        parts.append(f"## {escape_markdown(group.task)} ({group.kind})\n")
        views = study_views(group.study) + [result_view(table, tables.machines) for table in group.tables]
        views += [view for block in tables.slips if block.task == group.task for view in slip_views(block)]
        parts += [markdown_table(view) for view in ([pose_view(group.curve)] if len(group.curve) else []) + views]
    if len(tables.beside):
        parts.append("## Simulated beside real\n")
        parts += [markdown_table(view) for view in beside_views(tables.beside)]
    if len(tables.probes):
        parts.append("## What should not suffice\n")
        parts += [markdown_table(view) for view in probe_views(tables.probes)]
    if len(tables.laws):
        parts.append("## What must hold\n\n" + markdown_table(laws_view(tables.laws)))
    return "\n".join(parts)


def csv_tables(tables: BoardTables) -> dict[str, pd.DataFrame]:
    """Return the tables that have rows, by file name without its ending."""
    named = {"records": tables.cells}
    for table in (*tables.papers, *tables.tasks):
        stem = f"paper-table-{table.paper_table}" if table.paper_table else f"{table.task}-{table.variant}"
        name = slug(f"{stem}-{table.apart}-{table.kind}-{table.dataset_hash[:8]}-p{table.protocol_version}")
        while name in named:
            name += "x"
        named[name] = table.frame
    named |= {"probes": tables.probes, "laws": tables.laws, "pose": tables.pose, "speed": tables.speed}
    named |= {"simulated-beside-real": tables.beside}
    named |= {"slip": metrics_frame(tables.slips)}
    return {name: frame for name, frame in named.items() if len(frame)}


def slug(name: str) -> str:
    """Return a file name of letters, digits, dots and dashes that stays in its folder."""
    return re.sub(r"[^a-z0-9.]+", "-", name.lower()).strip(".-")[:120] or "table"


def harmless(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the frame with text that a spreadsheet would take for a formula marked as text by an apostrophe."""
    return frame.map(lambda v: f"'{v}" if isinstance(v, str) and v.startswith(("=", "+", "-", "@", "\t", "\r")) else v)
