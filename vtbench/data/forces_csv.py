"""The CSV of a folder of recordings: which image belongs to which forces.

The folder holds `forces.csv`, one line a press under a heading, and the images that its lines name:

    file, object, f1, f2, ..., fN                          required
    press, unit, session, rest_file, total_force_n         optional

`file` and `rest_file` (the same camera before contact) are paths inside the folder, `object` is a name, `f1..fN` are
the taxels' forces in newtons, `press` is `deep` (default) or `shallow`, `unit` and `session` are whole numbers
(default 0), `total_force_n` is the total normal force in newtons. All images have one size; 8-bit grey or colour,
any format that OpenCV reads.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from vtbench.data.format import PRESSES
from vtbench.registry import hint

FORCES_FILE = "forces.csv"
_REQUIRED = ("file", "object")
_OPTIONAL = ("press", "unit", "session", "rest_file", "total_force_n")
_TAXEL = re.compile(r"f([1-9]\d*)")


def read_forces(path: Path) -> pd.DataFrame:
    """The CSV with its defaults filled in, every cell checked, and `round` (the object's how-many-th press).

    Raises:
        ValueError: not there, not a CSV of this form, or a bad cell; names line (the heading is 1) and column.
    """
    columns, lines = _read_cells(path)
    taxels = _check_columns(path, columns)
    frame = pd.DataFrame(lines, columns=columns, dtype=str)
    filled = (*_REQUIRED, *(("rest_file",) if "rest_file" in columns else ()))
    for column in filled:
        _refuse(path, frame, column, frame[column] == "", "expected a value")
    _refuse(path, frame, "file", frame["file"].duplicated(), "an earlier line names it already")
    for column in (*taxels, *(("total_force_n",) if "total_force_n" in columns else ())):
        number = pd.to_numeric(frame[column], errors="coerce")
        most = np.finfo(np.float32 if column in taxels else np.float64).max  # as a dataset stores them
        _refuse(path, frame, column, ~(np.abs(number) <= most), "expected a finite number of newtons")
        frame[column] = number.astype(float)
    for column in ("unit", "session"):
        text = frame.get(column, pd.Series("0", index=frame.index))
        _refuse(path, frame, column, ~text.str.fullmatch(r"\d{1,9}"), "expected a whole number, 0 or more")
        frame[column] = text.astype(int)
    press = frame.get("press", pd.Series(PRESSES[0], index=frame.index))
    _refuse(path, frame, "press", ~press.isin(PRESSES), f"expected one of {', '.join(PRESSES)}")
    frame["press"] = press
    frame["round"] = frame.groupby("object").cumcount()
    return frame


def taxel_columns(columns: Sequence[str]) -> list[str]:
    """The force columns in the order of their taxels."""
    return sorted(filter(_TAXEL.fullmatch, columns), key=lambda column: int(column[1:]))


def _read_cells(path: Path) -> tuple[list[str], list[list[str]]]:
    """Heading and lines of cells, as many in each line as in the heading."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            cells = [[cell.strip() for cell in line] for line in csv.reader(file)]
    except FileNotFoundError:
        raise ValueError(
            f"{path}: no such file; expected a CSV with the columns file, object, f1, f2, ... beside the images"
        ) from None
    except (csv.Error, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: not readable as CSV in UTF-8 ({error})") from error
    while cells and not any(cells[-1]):
        cells.pop()
    if len(cells) < 2:
        raise ValueError(f"{path}: no presses; expected a heading and one line for each press")
    columns, lines = cells[0], cells[1:]
    if len(columns) == 1 and (mark := next((mark for mark in ";\t|" if mark in columns[0]), None)):
        raise ValueError(f"{path}: expected columns parted by commas, got {mark!r}; save it with commas (and points)")
    forces = len(taxel_columns(columns))
    for number, line in enumerate(lines, start=2):
        if len(line) != len(columns):
            got = forces + len(line) - len(columns)
            raise ValueError(
                f"{path}, line {number}: {len(line)} cells, the heading has {len(columns)} "
                f"({got} forces for {forces} taxels?)"
            )
    return columns, lines


def _check_columns(path: Path, columns: list[str]) -> list[str]:
    """The force columns; ValueError for a column that is missing, unknown or given twice."""
    known = (*_REQUIRED, *_OPTIONAL)
    for column in _REQUIRED:
        if column not in columns:
            raise ValueError(f"{path}: column {column!r} is missing; there are {', '.join(columns)}")
    for column in columns:
        if columns.count(column) > 1:
            raise ValueError(f"{path}: column {column!r} is given twice")
        if column not in known and not _TAXEL.fullmatch(column):
            raise ValueError(f"{path}: unknown column {column!r}{hint(column, known)} (forces are f1, f2, ...)")
    taxels = taxel_columns(columns)
    if not taxels or taxels[-1] != f"f{len(taxels)}":
        found = ", ".join(taxels) or "none"
        raise ValueError(f"{path}: expected the force columns f1, f2, ... without a gap, got {found}")
    return taxels


def _refuse(path: Path, frame: pd.DataFrame, column: str, bad: Any, expected: str) -> None:
    rows = np.flatnonzero(np.asarray(bad))
    if rows.size:
        more = f" (and {rows.size - 1} more lines)" if rows.size > 1 else ""
        value = frame[column].iloc[rows[0]]
        raise ValueError(f"{path}, line {rows[0] + 2}, column {column!r}: {expected}, got {value!r}{more}")
