"""A folder of images and forces -> dataset: one CSV (`vtbench.data.forces_csv`), or any layout with a mapping."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from vtbench.data.forces_csv import FORCES_FILE, read_forces, taxel_columns
from vtbench.data.format import REQUIRED_COLUMNS, SAMPLES_PER_SHARD
from vtbench.data.mapped_forces import find_presses
from vtbench.data.mapping import Mapping
from vtbench.data.meta import Plan
from vtbench.data.rows import image_cell
from vtbench.data.shards import write_shards
from vtbench.data.table import Row
from vtbench.data.writer import generator


def import_folder(
    folder: Path | str,
    out: Path | str,
    *,
    forces: str = FORCES_FILE,
    mapping: Mapping | None = None,
    name: str | None = None,
    progress: bool = True,
    resume: bool = True,
    samples_per_shard: int = SAMPLES_PER_SHARD,
) -> Path:
    """Turn a folder of images and forces into a dataset in `out` and return `out`.

    Args:
        folder: where the images and the forces are; `vtbench.data.forces_csv` describes both.
        out: folder to write; importing the same recordings again changes nothing.
        forces: name of the CSV in `folder`.
        mapping: how a folder of any other layout is to be read, instead of `forces`.
        name: the dataset's name, the folder's by default.
        progress: show a bar on standard error when it is a terminal.
        resume: keep whole shards of an earlier call; False starts over.
        samples_per_shard: rows of one Parquet file.

    Raises:
        ValueError: a missing file or column, a force that is not a number, images of different sizes; file and
            line are named (the heading is line 1). Nothing is written then.
        OSError: `out` cannot be written.
    """
    folder, out = Path(folder), Path(out)
    files: tuple[str, ...] = (forces,)
    source: dict[str, Any] = {"forces": forces}
    problems: tuple[str, ...] = ()
    if mapping is None:
        frame = read_forces(folder / forces)
    else:
        found = find_presses(folder, mapping)
        frame, files, problems = found.frame, found.files, found.problems
        source = {"mapping": mapping.model_dump(mode="json", exclude_defaults=True)}
        source |= {key: value for key in ("license", "citation") if (value := getattr(mapping, key))}
    size, checksum, pictures = ((0, 0), "", []) if problems else survey_images(folder, frame, files)
    if problems := (*problems, *pictures):
        more = f" (and {len(problems) - 1} more: --dry-run lists them)" if mapping and len(problems) > 1 else ""
        raise ValueError(f"{problems[0]}{more}")
    taxels = taxel_columns(list(frame.columns))
    columns = [*REQUIRED_COLUMNS]
    columns += ["image_rest"] if "rest_file" in frame else []
    columns += ["total_force_n"] if "total_force_n" in frame else []
    plan = Plan(
        kind="imported",
        name=name or folder.resolve().name,
        generator=generator(),
        source={**source, "sha256": checksum},
        samples=len(frame),
        samples_per_shard=samples_per_shard,
        classes=tuple(sorted(set(frame["object"]))),
        n_taxels=len(taxels),
        image_size=size,
        columns=tuple(columns),
    )
    make_row = _ImportedRow(folder, frame, frame[taxels].to_numpy(np.float32), plan)
    return write_shards(out, plan, make_row, jobs=1, progress=progress, resume=resume)


def survey_images(folder: Path, frame: pd.DataFrame, files: Sequence[str]) -> tuple[tuple[int, int], str, list[str]]:
    """Size (height, width) of the first image, SHA-256 over the forces' files and the images, and what is wrong."""
    checksum = hashlib.sha256()
    for file in files:
        checksum.update((folder / file).read_bytes())
    size: tuple[int, int] | None = None
    first = ""
    problems: list[str] = []
    for column in ("file", "rest_file"):
        for name in frame.get(column, ()):
            try:
                data = _read_bytes(folder, name)
                checksum.update(hashlib.sha256(data).digest())
                there = _decode(data, folder / name).shape[:2]
            except ValueError as error:
                problems.append(str(error))
                continue
            size, first = (size, first) if size else (there, name)
            if there != size:
                problems.append(
                    f"{folder / name}: image of {there[0]}x{there[1]} pixels, {first} has {size[0]}x{size[1]} "
                    "(height x width); all images must have one size"
                )
    return size or (0, 0), checksum.hexdigest(), list(dict.fromkeys(problems))


def _read_bytes(folder: Path, name: str) -> bytes:
    path = folder / name
    if not path.resolve().is_relative_to(folder.resolve()):
        raise ValueError(f"{folder}: {name!r} lies outside this folder")
    try:
        return path.read_bytes()
    except OSError as error:
        raise ValueError(f"{path}: image cannot be read ({error.strerror})") from error


def _decode(data: bytes, path: Path) -> NDArray[np.uint8]:
    """RGB image (height, width, 3) uint8 from the bytes of an image file."""
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    if image is None:
        raise ValueError(f"{path}: not an image that OpenCV can read")
    if image.dtype != np.uint8:
        raise ValueError(f"{path}: {image.dtype} pixels; expected 8 bits a channel")
    grey = image.ndim == 2 or image.shape[2] == 1
    code = cv2.COLOR_GRAY2RGB if grey else cv2.COLOR_BGRA2RGB if image.shape[2] == 4 else cv2.COLOR_BGR2RGB
    rgb: NDArray[np.uint8] = cv2.cvtColor(image, code)
    return rgb


@dataclass(frozen=True)
class _ImportedRow:
    """Row `index` of the CSV as a row of the dataset."""

    folder: Path
    frame: pd.DataFrame
    force: NDArray[np.float32]
    plan: Plan

    def __call__(self, index: int) -> Row:
        line = self.frame.iloc[index]
        row = {
            "id": line["file"],
            "object": line["object"],
            "label": self.plan.classes.index(line["object"]),
            "press": line["press"],
            "unit": int(line["unit"]),
            "session": int(line["session"]),
            "round": int(line["round"]),
            "image": self._image(line["file"]),
            "force": self.force[index],
        }
        if "rest_file" in self.frame:
            row["image_rest"] = self._image(line["rest_file"])
        if "total_force_n" in self.frame:
            row["total_force_n"] = float(line["total_force_n"])
        return row

    def _image(self, name: str) -> tuple[bytes, str]:
        path = self.folder / name
        return image_cell(_decode(_read_bytes(self.folder, name), path), self.plan.image_size, f"{name}.png")
