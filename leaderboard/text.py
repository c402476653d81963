"""Views as plain text: Markdown and aligned columns for a terminal; text that comes from records is made harmless."""

from __future__ import annotations

import re
import unicodedata

from leaderboard.views import FLAG, Cell, View

_MARKDOWN = re.compile(r"([\\`*_{}\[\]<>|#~$])")


def markdown_table(view: View) -> str:
    """Return the view as a Markdown table under a heading, its notes as a list below."""
    heads = [escape_markdown(column.title) for column in view.columns]
    rules = ["--:" if column.numeric else ":--" for column in view.columns]
    lines = [f"### {escape_markdown(view.title)}", "", _line(heads), _line(rules)]
    lines += [_line([_markdown_cell(cell) for cell in row]) for row in view.rows]
    lines += ["", *(f"- {escape_markdown(note)}" for note in view.notes)] if view.notes else []
    return "\n".join(lines) + "\n"


def escape_markdown(text: str) -> str:
    """Return text in which Markdown and HTML see no markup, on one line."""
    return _MARKDOWN.sub(r"\\\1", printable(text)).replace("&", "&amp;").replace("\\<", "&lt;").replace("\\>", "&gt;")


def console_table(view: View, width: int = 100) -> str:
    """Return the view as aligned text no wider than `width` where its columns allow; notes are left to the page."""
    rooms = [
        max((_cells(printable(row[at].detail)) for row in view.rows), default=0) if column.numeric else 0
        for at, column in enumerate(view.columns)
    ]
    texts = [[_joined(cell, room) for cell, room in zip(row, rooms, strict=True)] for row in view.rows]
    heads = [printable(column.title) for column in view.columns]
    widths = [max(map(_cells, column)) for column in zip(heads, *texts, strict=True)]
    widest = max(12, width // 2)
    widths = [min(w, widest) for w in widths]
    numeric = [column.numeric for column in view.columns]
    lines = [_aligned(heads, widths, numeric), "  ".join("─" * w for w in widths)]
    for number, row in enumerate(texts):
        if number in view.breaks:
            lines.append("")
        lines.append(_aligned(row, widths, numeric))
    return "\n".join(lines)


def printable(text: str) -> str:
    """Return text on one line without control characters: a terminal or a page must not obey a record."""
    clean = "".join(c if unicodedata.category(c)[0] != "C" else " " for c in text)
    return " ".join(clean.split())


def _joined(cell: Cell, room: int) -> str:
    """Return text and detail; in a numeric column the details share a width, so that figures stand below each other."""
    text, detail = printable(cell.text + cell.mark + _flag(cell)), printable(cell.detail)
    if room:
        return f"{text} {' ' * (room - _cells(detail))}{detail}"
    return f"{text} {detail}".strip()


def _flag(cell: Cell) -> str:
    return (f" {FLAG}" if cell.flag else "") + (f" [{cell.badge}]" if cell.badge else "")


def _markdown_cell(cell: Cell) -> str:
    text = escape_markdown(cell.text + cell.mark + _flag(cell))
    return f"{text} ({escape_markdown(cell.detail)})" if cell.detail else text


def _line(cells: list[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _aligned(texts: list[str], widths: list[int], numeric: list[bool]) -> str:
    cells = []
    for text, width, right in zip(texts, widths, numeric, strict=True):
        shown = text if _cells(text) <= width else text[: width - 1] + "…"
        pad = " " * (width - _cells(shown))
        cells.append(pad + shown if right else shown + pad)
    return "  ".join(cells).rstrip()


def _cells(text: str) -> int:
    """Return the number of terminal cells that text takes: two for wide characters, none for combining ones."""
    wide = {"W": 2, "F": 2}
    return sum(0 if unicodedata.combining(c) else wide.get(unicodedata.east_asian_width(c), 1) for c in text)
