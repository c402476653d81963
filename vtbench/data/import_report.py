"""What an import would find, before anything is written."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vtbench.data.folder_import import survey_images
from vtbench.data.forces_csv import read_forces, taxel_columns
from vtbench.data.mapped_forces import Found, find_presses
from vtbench.data.mapping import Mapping

_ROWS = 3


@dataclass(frozen=True)
class Report:
    """What a folder holds under a mapping.

    Attributes:
        counts: what was found, by its name.
        rows: the first presses, as they would be imported.
        problems: one line each; empty when the folder can be imported.
    """

    counts: dict[str, Any]
    rows: list[dict[str, Any]]
    problems: list[str]


def dry_run(folder: Path, mapping: Mapping) -> Report:
    """Read everything and write nothing; ValueError where nothing fits the mapping at all."""
    found: Found = find_presses(folder, mapping)
    frame, problems = found.frame, list(found.problems)
    if not len(frame):
        return Report({"files": len(found.files), "presses": 0}, [], problems)
    usable = frame[frame["file"] != ""]
    size, _, images = survey_images(folder, usable, found.files)
    taxels = taxel_columns(list(frame.columns))
    force = frame[taxels]
    counts = {
        "files": len(found.files),
        "presses": len(frame),
        "objects": {str(name): int(count) for name, count in frame["object"].value_counts(sort=False).items()},
        "taxels": len(taxels),
        "force_n": [round(float(force.min().min()), 4), round(float(force.max().max()), 4)],
        "units": int(frame["unit"].nunique()),
        "sessions": len(frame[["unit", "session"]].drop_duplicates()),
        "deep": int((frame["press"] == "deep").sum()),
        "shallow": int((frame["press"] == "shallow").sum()),
        "rest_frames": "rest_file" in frame,
        "image_size": list(size),
        "numbered": found.numbered,
    }
    rows = frame.drop(columns=["round", *taxels[3:]]).head(_ROWS)
    return Report(
        counts, [{str(key): value for key, value in row.items()} for row in rows.to_dict("records")], problems + images
    )


def plain_mapping(folder: Path, forces: str) -> Mapping:
    """The mapping of a folder that has our own `forces.csv`; ValueError where it is none, as an import gives."""
    columns = read_forces(folder / forces).columns
    given = {field: field for field in ("object", "press", "unit", "session") if field in _heading(folder / forces)}
    more = {"rest": "{rest_file}"} if "rest_file" in columns else {}
    more |= {"total_force": "total_force_n"} if "total_force_n" in columns else {}
    return Mapping(forces=(forces,), image="{file}", **given, **more)


def _heading(path: Path) -> list[str]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        return [cell.strip() for cell in next(csv.reader(file), [])]
