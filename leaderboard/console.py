"""The board in a terminal: what a run prints at its end."""

from __future__ import annotations

import textwrap

from leaderboard.contents import BoardTables
from leaderboard.labels import beside
from leaderboard.sections import laws_view, pose_view, probe_views, result_view
from leaderboard.slip_views import slip_views, table_iv
from leaderboard.studies import study_views
from leaderboard.text import console_table, printable
from leaderboard.views import View

WIDTH = 110


def format_console(tables: BoardTables) -> str:
    """Return compact tables and notices as text; the page has the notes, plots and records."""
    parts = [_titled(result_view(table, tables.machines), table.kind) for table in tables.papers]
    parts += [_titled(view, view.kind) for block in tables.slips if (view := table_iv(block)) is not None]
    for group in tables.groups:
        if len(group.curve):
            parts.append(_titled(pose_view(group.curve), group.kind, f"{group.task}, accuracy by unknown shift"))
        parts += [_titled(view, group.kind, f"{group.task}, {view.title}") for view in study_views(group.study)]
        parts += [
            _titled(
                result_view(table, tables.machines),
                table.kind,
                f"{table.task}, {beside(table.variant, table.label)}{table.apart and f', {table.apart}'}",
            )
            for table in group.tables
        ]
        slips = [block for block in tables.slips if block.task == group.task]
        parts += [_titled(view, group.kind) for block in slips for view in slip_views(block, conditions=False)]
    for view in probe_views(tables.probes):
        parts.append(_titled(view, "what should not suffice", f"Probes of {view.title}"))
    if len(tables.laws):
        parts.append(_titled(laws_view(tables.laws), "what must hold"))
    if tables.notices:
        parts.append("\n".join(_wrapped(f"{notice.kind}: {notice.text}") for notice in tables.notices))
    return "\n\n".join(parts) + "\n"


def _titled(view: View, what: str, title: str = "") -> str:
    head = f"{printable(title or view.title)} ({what})"
    return f"{head}\n\n{console_table(view, WIDTH)}"


def _wrapped(line: str) -> str:
    return textwrap.fill(printable(line), WIDTH, initial_indent="- ", subsequent_indent="  ", break_on_hyphens=False)
