"""What a table looks like before it is Markdown, text or HTML: columns, cells with a lighter part, notes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from leaderboard.caution import MARK
from leaderboard.frame import Row
from leaderboard.ranks import Rank

NOT_RUN = "–"
MOST_LETTERS = 4
FLAG = "⚠"


@dataclass(frozen=True)
class Column:
    """A heading; `hint` explains it, `sortable` is False where an order would mislead, `wrap` lets long text break.

    `smallest_first` is the order of the first click on a numeric heading.
    """

    title: str
    numeric: bool = False
    hint: str = ""
    sortable: bool = True
    wrap: bool = False
    smallest_first: bool = False


@dataclass(frozen=True)
class Cell:
    """What a cell says: `text` in full ink, `detail` lighter; `sort` orders a numeric column, `key` names a record.

    `mark` points to a note and hangs beside the text, so that figures stay below each other; `flag` is a warning that
    goes wherever the score goes; `badge` is the standing of a submission.

    `same` marks a name that repeats the row above: a page may pale it while rows stand in their order.
    """

    text: str
    detail: str = ""
    sort: float | None = None
    key: str = ""
    hint: str = ""
    tone: Literal["", "muted", "good", "bad"] = ""
    same: bool = False
    mark: str = ""
    flag: str = ""
    badge: str = ""


@dataclass(frozen=True)
class View:
    """A table ready to be drawn. `header` is the column that names a row; `breaks` are rows that begin a group."""

    id: str
    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[str, ...] = ()
    header: int = 0
    breaks: frozenset[int] = frozenset()
    kind: str = ""


def number(value: float | None, digits: int = 1) -> str:
    """Return a figure with fixed digits, or a dash where there is none."""
    return NOT_RUN if value is None else f"{value:,.{digits}f}"


def span(low: float | None, high: float | None, digits: int = 1) -> str:
    """Return an interval as `96.8–99.6`, or nothing."""
    return "" if low is None or high is None else f"{low:.{digits}f}–{high:.{digits}f}"


def microseconds(value: float | None) -> str:
    """Return a duration with two figures that matter at least: 3.4, 120, 5,310."""
    return number(value, 1 if value is not None and value < 10 else 0)


def score_cell(row: Row, prefix: str = "", unit: str = "%") -> Cell:
    """Return the score under `prefix` with its interval; a row without a score says what became of it."""
    name = prefix.rstrip("_") or "value"
    value, state = row.get(name), row.get(f"{prefix}state")
    key = row.get(f"{prefix}key") or ""
    if state is None:
        return Cell(NOT_RUN, hint="not run", tone="muted")
    if value is None:
        return Cell(str(state), key=key, hint=brief(row.get(f"{prefix}reason") or ""), tone="bad")
    digits = 1 if unit == "%" else 3
    return Cell(
        number(value, digits),
        (MARK if row.get(f"{prefix}coverage") else "")
        + span(row.get(f"{prefix}low"), row.get(f"{prefix}high"), digits),
        sort=value,
        key=key,
        hint=_from(row, prefix),
        flag=row.get(f"{prefix}probe") or "",
    )


def rank_cell(row: Row, prefix: str = "") -> Cell:
    """Return the ranks that the score under `prefix` may hold, with the letters that tied methods share."""
    best, worst = row.get(f"{prefix}rank_best"), row.get(f"{prefix}rank_worst")
    if best is None or worst is None:
        return Cell(NOT_RUN, tone="muted")
    said = Rank(int(best), int(worst), row.get(f"{prefix}letters") or "")
    many = len(said.letters) > MOST_LETTERS
    letters = f"{said.letters[: MOST_LETTERS - 1]}…" if many else said.letters
    return Cell(
        said.text, letters, sort=best + worst / 1000, hint=f"tied with methods that share a letter: {said.letters}"
    )


def brief(text: str, limit: int = 240) -> str:
    """Return text on one line and no longer than `limit`."""
    line = " ".join(text.split())
    return line if len(line) <= limit else line[: limit - 1] + "…"


def paled(rows: Sequence[tuple[Cell, ...]], columns: int) -> tuple[tuple[Cell, ...], ...]:
    """Return the rows with leading cells, up to `columns`, marked where they and those before them repeat."""
    out = []
    for i, row in enumerate(rows):
        same = 0
        while i and same < columns and row[same].text == rows[i - 1][same].text:
            same += 1
        out.append((*(replace(cell, same=True) for cell in row[:same]), *row[same:]))
    return tuple(out)


def breaks_of(keys: Sequence[Any]) -> frozenset[int]:
    """Return the positions at which a key differs from the one before."""
    return frozenset(i for i in range(1, len(keys)) if keys[i] != keys[i - 1])


def _from(row: Row, prefix: str) -> str:
    n, groups, interval = (row.get(f"{prefix}{name}") for name in ("n", "groups", "interval"))
    said = [f"{n:.0f} predictions" if n else "", f"{groups:.0f} groups" if groups else "", interval or ""]
    said += [row.get(f"{prefix}{name}") or "" for name in ("coverage", "probe")]
    return ", ".join(part for part in said if part)
