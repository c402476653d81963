"""A folder and its mapping -> the presses it holds, and every problem with its file, line and column."""

from __future__ import annotations

import re
import string
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
import pandas as pd

from vtbench.data.mapped_files import ForcesFile, find_files, newtons, number, read_file, to_newtons
from vtbench.data.mapping import FIELDS, PLACES, Mapping
from vtbench.registry import hint


@dataclass(frozen=True)
class Found:
    """What a folder holds.

    Attributes:
        frame: a line a press with the columns of `vtbench.data.forces_csv`, and `round`.
        files: the files of forces that were read.
        problems: what is wrong, one line each; empty when the folder can be imported.
        numbered: units and sessions that are no whole numbers, and the number each got.
    """

    frame: pd.DataFrame
    files: tuple[str, ...]
    problems: tuple[str, ...]
    numbered: dict[str, dict[str, int]]


def find_presses(folder: Path, mapping: Mapping) -> Found:
    """Read every file of forces that the mapping names.

    Raises:
        ValueError: nothing there that fits the mapping at all.
    """
    if not folder.is_dir():
        raise ValueError(f"{folder}: no such folder")
    names = find_files(folder, mapping)
    rows: list[dict[str, Any]] = []
    problems: list[str] = []
    width: tuple[int, str] | None = None
    for name in names:
        try:
            file = read_file(folder, name, mapping)
        except ValueError as error:
            problems.append(str(error))
            continue
        width = width or (len(file.taxels), name)
        if len(file.taxels) != width[0]:
            problems.append(f"{folder / name}: {len(file.taxels)} taxels, {width[1]} has {width[0]}")
            continue
        rows += _presses(folder, file, mapping, problems)
    frame = pd.DataFrame(rows)
    numbered: dict[str, dict[str, int]] = {}
    if len(frame):
        for place, count in frame["file"].value_counts().items():
            if place and count > 1:
                problems.append(f"{folder / str(place)}: the image of {count} presses; each needs its own")
        for field in ("unit", "session"):
            frame[field], codes = _numbers(frame[field])
            numbered |= {field: codes} if codes else {}
        frame["round"] = frame.groupby("object").cumcount()
    return Found(frame, tuple(names), tuple(problems), numbered)


def _presses(folder: Path, file: ForcesFile, mapping: Mapping, problems: list[str]) -> list[dict[str, Any]]:
    path = folder / file.name
    known: dict[str, str] = {}
    if mapping.forces_path:
        match = re.search(mapping.forces_path, file.name)
        if match is None:
            problems.append(f"{path}: forces_path '{mapping.forces_path}' is not found in {file.name!r}")
            return []
        known = {key: value or "" for key, value in match.groupdict().items()}
    place = PurePosixPath(file.name)
    known |= {"folder": place.parent.as_posix(), "stem": place.stem}
    unknown = [name for name in mapping.names if name not in (*file.columns, *known, *PLACES, *mapping.groups)]
    if unknown:
        near = hint(unknown[0], [*file.columns, *known, *PLACES]) or f"; there are {', '.join((*file.columns, *known))}"
        problems.append(f"{path}: {{{unknown[0]}}} in a path of images is no column and no group{near}")
        return []
    return [_press(folder, file, row, mapping, known, problems) for row in _rows(file, mapping)]


def _rows(file: ForcesFile, mapping: Mapping) -> range:
    return range(1) if mapping.each_file == "press" else range(len(file.lines))


def _press(
    folder: Path, file: ForcesFile, row: int, mapping: Mapping, known: dict[str, str], problems: list[str]
) -> dict[str, Any]:
    path = folder / file.name
    where = f"{path}, line {file.lines[row][0]}"
    cells = dict(zip(file.columns, file.lines[row][1], strict=True)) | known | {"line": str(row + 1)}
    image = _image(folder, mapping.image, cells, where, problems)
    if mapping.image_path and image:
        match = re.search(mapping.image_path, image)
        if match is None:
            problems.append(f"{where}: image_path '{mapping.image_path}' is not found in {image!r}")
        else:
            known = known | {key: value or "" for key, value in match.groupdict().items()}
    values = {field: known.get(field, cells.get(getattr(mapping, field) or "")) for field in FIELDS}
    if not values["object"]:
        problems.append(f"{where}, column {mapping.object or 'object'!r}: expected the name of an object, got nothing")
    press = mapping.press_of(values["press"] or "deep")
    if press is None:
        problems.append(
            f"{where}, column {mapping.press or 'press'!r}: expected deep or shallow, got {values['press']!r} "
            f"(values: {{{values['press']}: deep}} in the mapping?)"
        )
    hold = _hold(len(file.lines), mapping) if mapping.each_file == "press" else range(row, row + 1)
    force = np.mean([newtons(file, path, line, mapping, problems) for line in hold], axis=0)
    found = {
        "file": image,
        "object": values["object"] or "",
        "press": press or "deep",
        "unit": values["unit"] or "0",
        "session": values["session"] or "0",
        **{f"f{taxel + 1}": value for taxel, value in enumerate(force)},
    }
    if mapping.rest is not None:
        found["rest_file"] = _image(folder, mapping.rest, cells | known, where, problems)
    if mapping.total_force is not None:
        found["total_force_n"] = _total(file, hold, mapping, path, problems)
    return found


def _hold(lines: int, mapping: Mapping) -> range:
    """Lines of the hold of a file that holds one press, at least one."""
    first = min(int(mapping.hold[0] * lines), lines - 1)
    return range(first, max(first + 1, round(mapping.hold[1] * lines)))


def _total(file: ForcesFile, hold: range, mapping: Mapping, path: Path, problems: list[str]) -> float:
    """Mean total force over the hold, newtons."""
    column = mapping.total_force or ""
    in_newtons = mapping if mapping.force_unit != "counts" else replace_unit(mapping)
    values = []
    for row in hold:
        value = number(file.cell(row, column), mapping)
        if value is None:
            text = file.cell(row, column)
            problems.append(f"{path}, line {file.lines[row][0]}, column {column!r}: expected a number, got {text!r}")
        values.append(to_newtons(value or 0.0, in_newtons))
    return float(np.mean(values))


def replace_unit(mapping: Mapping) -> Mapping:
    """The mapping with newtons for counts."""
    return mapping.model_copy(update={"force_unit": "N", "newtons_per_count": None})


class _Path(string.Formatter):
    """Fills a template with texts; a format such as `:04d` takes them as whole numbers."""

    def format_field(self, value: Any, format_spec: str) -> Any:
        return super().format_field(int(value) if format_spec.endswith("d") else value, format_spec)


def _image(folder: Path, template: str, cells: dict[str, str], where: str, problems: list[str]) -> str:
    """Path of an image below the folder, empty where it cannot be told."""
    try:
        name = PurePosixPath(_Path().vformat(template, (), cells)).as_posix()
    except (ValueError, KeyError, IndexError, AttributeError) as error:
        problems.append(f"{where}: the path {template!r} cannot be filled ({error})")
        return ""
    if name.startswith("/") or ".." in PurePosixPath(name).parts:
        problems.append(f"{where}: {name!r} lies outside the folder")
        return ""
    if "*" not in name:
        return name
    fits = sorted(path.relative_to(folder).as_posix() for path in folder.glob(name) if path.is_file())
    if len(fits) != 1:
        problems.append(f"{where}: expected one image that fits {name!r}, found {len(fits)}")
        return ""
    return fits[0]


def _numbers(texts: pd.Series[str]) -> tuple[pd.Series[int], dict[str, int]]:
    """Whole numbers as they are; other names counted from 0 in their order."""
    if texts.str.fullmatch(r"\d{1,9}").all():
        return texts.astype(int), {}
    codes = {name: code for code, name in enumerate(sorted(set(texts)))}
    return texts.map(codes), codes
