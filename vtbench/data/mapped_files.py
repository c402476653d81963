"""Files of forces as a mapping describes them -> cells by column, each with its line, or problems in words."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vtbench.data.mapping import NEWTONS, Mapping
from vtbench.registry import hint


@dataclass(frozen=True)
class ForcesFile:
    """One file of forces.

    Attributes:
        name: its path below the folder.
        columns: names in the heading; none of an NPY file.
        lines: (line in the file from 1, cells) of each.
        taxels: columns of the taxels in their order.
        array: (lines, taxels) of an NPY file.
    """

    name: str
    columns: tuple[str, ...]
    lines: tuple[tuple[int, tuple[str, ...]], ...]
    taxels: tuple[str, ...]
    array: NDArray[np.float64] | None = None

    def cell(self, row: int, column: str) -> str:
        """Text of a cell."""
        return self.lines[row][1][self.columns.index(column)]


def find_files(folder: Path, mapping: Mapping) -> list[str]:
    """Paths below `folder` of the files that the mapping names, sorted; ValueError for a pattern that fits none."""
    found: list[str] = []
    for pattern in mapping.forces:
        if Path(pattern).is_absolute() or ".." in Path(pattern).parts:
            raise ValueError(f"forces: expected a path inside the folder, got {pattern!r}")
        fits = sorted(path.relative_to(folder).as_posix() for path in folder.glob(pattern) if path.is_file())
        if not fits:
            there = [path.relative_to(folder).as_posix() for path in sorted(folder.rglob("*.csv"))]
            near = hint(pattern, there) or (
                f"; there are {', '.join(there[:3])}" if there else "; it has no CSV at all"
            )
            raise ValueError(f"{folder}: forces: nothing fits {pattern!r}{near}")
        found += [name for name in fits if name not in found]
    return found


def read_file(folder: Path, name: str, mapping: Mapping) -> ForcesFile:
    """One file, its heading checked.

    Raises:
        ValueError: not readable, a column that is missing or given twice, or a line of another length; one line.
    """
    path = folder / name
    wanted = {key: getattr(mapping, key) for key in ("object", "press", "unit", "session", "total_force")}
    if path.suffix.lower() == ".npy":
        if key := next((key for key, column in wanted.items() if column), None):
            raise ValueError(f"{path}: an NPY file has no column {wanted[key]!r}; take {key} from a path, or leave it")
        return _npy(path, name)
    lines = list(_lines(path, mapping))
    if len(lines) < 2:
        raise ValueError(f"{path}: expected a heading and lines under it, found {len(lines)} lines")
    (number, columns), *cells = lines
    if len(columns) == 1 and (mark := next((mark for mark in ",;\t|" if mark in columns[0]), None)):
        raise ValueError(f"{path}, line {number}: one column; are they parted by {mark!r}? (delimiter: {mark!r})")
    for column in columns:
        if columns.count(column) > 1:
            raise ValueError(f"{path}, line {number}: column {column!r} is given twice")
    for column in filter(None, wanted.values()):
        if column not in columns:
            raise ValueError(f"{path}, line {number}: no column {column!r}{_near(column, columns)}")
    for line, row in cells:
        if len(row) != len(columns):
            raise ValueError(f"{path}, line {line}: {len(row)} cells, the heading has {len(columns)}")
    return ForcesFile(name, columns, tuple(cells), _taxels(path, number, columns, mapping))


def newtons(file: ForcesFile, path: Path, row: int, mapping: Mapping, problems: list[str]) -> list[float]:
    """Forces of a line in newtons; a cell that is no finite number is added to `problems`, and becomes 0."""
    if file.array is not None:
        values = list(file.array[row])
        if not np.isfinite(values).all():
            problems.append(f"{path}, row {row}: not finite at taxel {int(np.argmin(np.isfinite(values)))}")
            values = [0.0] * len(values)
        return [to_newtons(value, mapping) for value in values]
    found = []
    for column in file.taxels:
        value = number(file.cell(row, column), mapping)
        if value is None:
            text = file.cell(row, column)
            mark = " (decimal: ',' in the mapping?)" if re.fullmatch(r"-?\d+,\d+", text) else ""
            problems.append(
                f"{path}, line {file.lines[row][0]}, column {column!r}: expected a finite number, got {text!r}{mark}"
            )
        found.append(to_newtons(value or 0.0, mapping))
    return found


def number(text: str, mapping: Mapping) -> float | None:
    """A finite number within float32, None for anything else."""
    try:
        value = float(text.replace(",", ".") if mapping.decimal == "," else text)
    except ValueError:
        return None
    return value if abs(value) <= float(np.finfo(np.float32).max) else None


def to_newtons(value: float, mapping: Mapping) -> float:
    """A value in the mapping's unit, in newtons."""
    if mapping.newtons_per_count is not None:
        return (value - mapping.zero_count) * mapping.newtons_per_count
    return value * NEWTONS[mapping.force_unit]


def _near(name: str, columns: Sequence[str]) -> str:
    return hint(name, columns) or f"; there are {', '.join(columns)}"


def _lines(path: Path, mapping: Mapping) -> Iterator[tuple[int, tuple[str, ...]]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            for _ in range(mapping.skip_lines):
                file.readline()
            reader = csv.reader(file, delimiter=mapping.delimiter)
            for row in reader:
                if any(cell.strip() for cell in row):
                    yield reader.line_num + mapping.skip_lines, tuple(cell.strip() for cell in row)
    except (csv.Error, UnicodeDecodeError, OSError) as error:
        raise ValueError(f"{path}: not readable as CSV in UTF-8 ({error})") from None


def _taxels(path: Path, line: int, columns: Sequence[str], mapping: Mapping) -> tuple[str, ...]:
    if not isinstance(mapping.taxels, str):
        for column in mapping.taxels:
            if column not in columns:
                raise ValueError(f"{path}, line {line}: no column {column!r} of taxels{_near(column, columns)}")
        return mapping.taxels
    matches = [(column, match) for column in columns if (match := re.fullmatch(mapping.taxels, column))]
    if not matches:
        raise ValueError(
            f"{path}, line {line}: no column fits taxels: '{mapping.taxels}'; there are {', '.join(columns)}"
        )
    if all(match.groups() and (match[1] or "").isdigit() for _, match in matches):
        matches.sort(key=lambda found: int(found[1][1]))
    return tuple(column for column, _ in matches)


def _npy(path: Path, name: str) -> ForcesFile:
    try:
        array = np.load(path, allow_pickle=False)
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: not readable as NPY ({' '.join(str(error).split())})") from None
    if array.ndim == 1:
        array = array[None]
    if array.ndim != 2 or array.dtype.kind not in "iuf" or not array.size:
        raise ValueError(f"{path}: {array.dtype} of shape {array.shape}; expected numbers (lines, taxels)")
    lines = tuple((row + 1, ()) for row in range(len(array)))
    return ForcesFile(name, (), lines, tuple(f"{i}" for i in range(array.shape[1])), array.astype(np.float64))
