"""What commands print: tables for people, JSON for programs."""

from __future__ import annotations

import json
import math
import shutil
import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

_GAP = "  "
_NARROWEST = 24


def print_json(value: Any) -> None:
    """Print JSON that any reader takes: NaN and infinities become null, paths text, arrays lists."""
    print(json.dumps(_plain(value), indent=2, ensure_ascii=False, allow_nan=False))


def print_table(columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Print rows under their headings (none: no line of them).

    Numbers stand to the right; a long last column wraps on a terminal.
    """
    cells = [[_text(value) for value in row] for row in rows]
    right = [all(isinstance(value, int | float) for value in column) for column in zip(*rows, strict=True)]
    right = right or [False] * len(columns)
    print("\n".join(_lines([list(columns), *cells] if columns else cells, right)))


def size_text(n_bytes: int) -> str:
    """A file size as people read it: `4.2 MB`."""
    for unit, scale in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if n_bytes >= scale:
            return f"{n_bytes / scale:.1f} {unit}"
    return f"{n_bytes} bytes"


def count_text(count: int, thing: str) -> str:
    """`1 sample`, `2 samples`."""
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"


def _lines(table: list[list[str]], right: list[bool]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    if sys.stdout.isatty():
        before = sum(widths[:-1]) + len(_GAP) * (len(widths) - 1)
        widths[-1] = min(widths[-1], max(_NARROWEST, shutil.get_terminal_size().columns - before - 1))
    lines = []
    for *row, last in table:
        for number, piece in enumerate(textwrap.wrap(last, widths[-1]) or [""]):
            start = row if number == 0 else [""] * len(row)
            padded = [
                text.rjust(width) if to_right else text.ljust(width)
                for text, width, to_right in zip([*start, piece], widths, right, strict=True)
            ]
            lines.append(_GAP.join(padded).rstrip())
    return lines


def _text(value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.2f}"
    return " ".join(str(value).split())


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, str) or value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if hasattr(value, "tolist"):  # NumPy scalars and arrays, without importing NumPy
        return _plain(value.tolist())
    if isinstance(value, Iterable):
        return [_plain(inner) for inner in value]
    return str(value)
