"""A first mapping file for a folder of recordings that is new, from the names its files and columns have."""

from __future__ import annotations

import csv
import re
from pathlib import Path

_IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
_LIKELY = {
    "object": ("object", "label", "class", "name", "material", "item"),
    "press": ("press", "depth", "kind"),
    "unit": ("unit", "sensor", "device"),
    "session": ("session", "run", "day", "date"),
    "total_force": ("total_force", "total_force_n", "fz", "load"),
}
_FRAME = ("file", "image", "frame", "filename", "img", "path")
_PREAMBLE = 20
_NUMBER = re.compile(r"[-+\d.,eE ]*")
_FOLDER = "(?P<object>[^/]+)/[^/]+$"


def suggest(folder: Path) -> str:
    """The text of a mapping file for `folder`, to be looked through and edited.

    Raises:
        ValueError: there is no CSV, or no image.
    """
    tables = sorted(path for path in folder.rglob("*.csv") if path.is_file()) if folder.is_dir() else []
    images = sorted(path for path in folder.rglob("*") if path.suffix.lower() in _IMAGES) if tables else []
    if not images:
        missing = "image" if tables else "CSV"
        raise ValueError(f"{folder}: expected a folder with images and CSV files of forces, found no {missing}")
    lines = [f"# from {len(tables)} CSV and {len(images)} images: look through it, then --dry-run"]
    lines.append(f"forces: {_quoted(_pattern(folder, tables))}")
    text = tables[0].read_text(encoding="utf-8-sig", errors="replace").splitlines()
    above, delimiter = _heading(text)
    columns = [cell.strip() for cell in next(csv.reader(text[above:], delimiter=delimiter), [])]
    beside = next((path for path in images if path.parent == tables[0].parent and path.stem == tables[0].stem), None)
    if beside is not None:
        lines.append("each_file: press  # its lines are averaged; hold: [0.4, 0.6] takes their middle")
    lines += [f"skip_lines: {above}"] if above else []
    if delimiter != ",":
        lines.append(f"delimiter: {'tab' if delimiter == chr(9) else _quoted(delimiter)}")
        lines += ["decimal: ','"] if any(re.search(r"\d,\d", line) for line in text[above:]) else []
    lines.append(f"taxels: {_quoted(_taxels(columns))}  # a regular expression, or a list of columns")
    lines.append("force_unit: N  # N, mN, g, kg, or counts with newtons_per_count and zero_count")
    given = {key: column for key, likely in _LIKELY.items() for column in columns if column.lower() in likely}
    if "object" not in given:
        key = "forces_path" if beside else "image_path"
        lines.append(f"{key}: {_quoted(_FOLDER)}  # the folder is named after the object")
    lines += [f"{key}: {_quoted(column)}" for key, column in given.items()]
    frame = next((column for column in columns if column.lower() in _FRAME), None)
    example = images[0].relative_to(folder).as_posix()
    image = f"{{folder}}/{{stem}}{beside.suffix}" if beside else f"{{{frame}}}" if frame else example
    lines.append(f"image: {_quoted(image)}  # columns and groups in braces; one is {example}")
    return "\n".join(lines) + "\n"


def _pattern(folder: Path, tables: list[Path]) -> str:
    """A name or pattern that fits the tables which lie as deep as the first."""
    first = tables[0].relative_to(folder)
    alike = [path for path in tables if len(path.relative_to(folder).parts) == len(first.parts)]
    if len(alike) == 1:
        return first.as_posix()
    name = first.name if all(path.name == first.name for path in alike) else "*.csv"
    return "*/" * (len(first.parts) - 1) + name


def _heading(text: list[str]) -> tuple[int, str]:
    """Lines above the heading, which is the first with the most words, and what parts its columns."""
    lines = text[:_PREAMBLE]
    mark = next((mark for mark in ";\t|" if any(line.count(mark) for line in lines)), ",")
    words = [sum(not _NUMBER.fullmatch(cell.strip()) for cell in line.split(mark)) for line in lines]
    return (words.index(max(words)) if words else 0), mark


def _taxels(columns: list[str]) -> str:
    """A pattern for the largest family of columns that differ in a number only."""
    families: dict[str, int] = {}
    for column in columns:
        if match := re.fullmatch(r"(.*?)(\d+)(\D*)", column):
            before, after = (re.escape(part).replace("\\ ", " ") for part in (match[1], match[3]))
            pattern = f"{before}(\\d+){after}"
            families[pattern] = families.get(pattern, 0) + 1
    return max(families, key=lambda pattern: families[pattern]) if families else r"f(\d+)"


def _quoted(text: str) -> str:
    """A YAML scalar that means itself."""
    return "'" + text.replace("'", "''") + "'"
