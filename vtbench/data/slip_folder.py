"""Slip sequences of one's own: `FOLDER/<label>/<name>.csv`, one sequence a file, one line a sample.

The label is the name of the sub-folder. `slip` means that the sequence holds a slip; any other label (`rest`,
`tapping`, `load_change`, ...) means that it holds none, and names its kind. One labelled `rest` also tells the noise.

The object is the file's name without its ending and without a number at its end: `mug_03.csv`, `mug-3.csv` and
`mug.csv` are all sequences with `mug`. Thresholds are learnt on the other objects.

The columns are taxels, as many in every file, in any unit. A heading is optional; with one, two columns may mean
something else: `slip` (0 or 1 for each sample, 1 while the object slips) tells the onset, `time_s` is checked against
the rate and left out.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

SLIP_LABEL = "slip"
REST_LABEL = "rest"
FEWEST_SAMPLES = 20
_NUMBERED = re.compile(r"(?P<object>.*?)[ _.-]*\d*")
_IRREGULAR = 0.5
"""A time step may differ from the period by this share of it."""


@dataclass(frozen=True)
class SlipSequence:
    """One file: its path below the folder, label, object, forces (T, taxels), and which samples slip, if it says so."""

    path: str
    label: str
    object: str
    force: NDArray[np.float64]
    slipping: NDArray[np.bool_] | None

    @property
    def has_slip(self) -> bool:
        """Whether the sequence holds a slip."""
        return self.label == SLIP_LABEL


def read_slip_folder(folder: Path | str, rate_hz: float) -> list[SlipSequence]:
    """Sequences below `folder`, sorted by path.

    Raises:
        ValueError: no such folder, no sequence with or without slip, a file that is not as described (it is named,
            with line and column where there is one), sequences with different numbers of taxels.
    """
    folder = Path(folder)
    if not rate_hz > 0:
        raise ValueError(f"rate_hz: expected a positive number of samples a second, got {rate_hz!r}")
    if not folder.is_dir():
        raise ValueError(f"{folder}: expected a folder with LABEL/NAME.csv below it, found none")
    paths = sorted(folder.glob("*/*.csv"))
    if not paths:
        raise ValueError(f"{folder}: expected sequences as LABEL/NAME.csv, such as slip/mug_01.csv; found no such file")
    sequences = [_read(path, path.relative_to(folder).as_posix(), rate_hz) for path in paths]
    first = sequences[0]
    for sequence in sequences:
        if sequence.force.shape[1] != first.force.shape[1]:
            raise ValueError(
                f"{folder / sequence.path}: {sequence.force.shape[1]} taxels, {first.path} has {first.force.shape[1]}; "
                "all sequences must have the same"
            )
    labels = sorted({sequence.label for sequence in sequences})
    if SLIP_LABEL not in labels:
        raise ValueError(f"{folder}: no sequences with slip; expected a sub-folder 'slip', found {', '.join(labels)}")
    if labels == [SLIP_LABEL] and any(sequence.slipping is None for sequence in sequences):
        raise ValueError(
            f"{folder}: no sequences without slip, so false alarms cannot be counted; add a sub-folder such as 'rest' "
            "or 'tapping', or a column 'slip' that says when each sequence slips"
        )
    return sequences


def object_of(name: str) -> str:
    """Object of a file's name: without a number at its end; the whole name where nothing else is left."""
    match = _NUMBERED.fullmatch(name)
    return (match["object"] if match else "") or name


def _read(path: Path, name: str, rate_hz: float) -> SlipSequence:
    heading, lines, first_line = _cells(path)
    values = _numbers(path, heading, lines, first_line)
    slipping = None
    if heading:
        if "time_s" in heading:
            _check_time(path, values[:, heading.index("time_s")], rate_hz, first_line)
        if "slip" in heading:
            column = values[:, heading.index("slip")]
            if not np.isin(column, (0, 1)).all():
                line = first_line + int(np.flatnonzero(~np.isin(column, (0, 1)))[0])
                raise ValueError(f"{path}, line {line}, column 'slip': expected 0 or 1")
            slipping = column == 1
        values = values[:, [at for at, title in enumerate(heading) if title not in ("time_s", "slip")]]
    if values.shape[1] == 0:
        raise ValueError(f"{path}: no columns of taxels")
    if len(values) < FEWEST_SAMPLES:
        raise ValueError(f"{path}: {len(values)} samples, expected at least {FEWEST_SAMPLES}")
    label = path.parent.name
    if slipping is not None and slipping.any() != (label == SLIP_LABEL):
        said = "no sample slips" if label == SLIP_LABEL else "some samples slip"
        raise ValueError(f"{path}: the label is {label!r}, but in its column 'slip' {said}")
    return SlipSequence(name, label, object_of(path.stem), values, slipping)


def _cells(path: Path) -> tuple[list[str], list[list[str]], int]:
    """Heading (empty without one), lines of cells, and the number of the first of them (the file's first is 1)."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = [[cell.strip() for cell in line] for line in csv.reader(file)]
    except (csv.Error, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: not readable as CSV in UTF-8 ({error})") from error
    while lines and not any(lines[-1]):
        lines.pop()
    if not lines:
        raise ValueError(f"{path}: empty")
    if len(lines[0]) == 1 and any(mark in lines[0][0] for mark in ";\t"):
        raise ValueError(f"{path}: expected columns separated by commas, found a semicolon or a tab between them")
    heading = [] if all(_is_number(cell) for cell in lines[0]) else lines[0]
    body = lines[1:] if heading else lines
    width = len(lines[0])
    for at, line in enumerate(body, start=2 if heading else 1):
        if len(line) != width:
            raise ValueError(f"{path}, line {at}: {len(line)} cells, the first line has {width}")
    return heading, body, 2 if heading else 1


def _numbers(path: Path, heading: Sequence[str], lines: list[list[str]], first_line: int) -> NDArray[np.float64]:
    try:
        values = np.array(lines, np.float64).reshape(len(lines), -1)
    except ValueError:
        values = np.array([[float(cell) if _is_number(cell) else np.nan for cell in line] for line in lines])
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        line, column = bad[0].tolist()
        title = repr(heading[column]) if heading else str(column + 1)
        raise ValueError(
            f"{path}, line {first_line + line}, column {title}: expected a finite number, got {lines[line][column]!r}"
        )
    return values


def _check_time(path: Path, time_s: NDArray[np.float64], rate_hz: float, first_line: int) -> None:
    steps = np.diff(time_s) * rate_hz
    wrong = np.flatnonzero(np.abs(steps - 1.0) > _IRREGULAR)
    if len(wrong):
        raise ValueError(
            f"{path}, line {first_line + 1 + int(wrong[0])}, column 'time_s': a step of "
            f"{steps[wrong[0]] / rate_hz:g} s, expected {1 / rate_hz:g} s at {rate_hz:g} Hz; resample it first"
        )


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
