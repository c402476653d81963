"""A folder -> what its submission.yaml says, or every problem of it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

import pydantic

from leaderboard.submission import SubmissionEntry, SubmissionFile
from vtbench.submissions.rules import Problem
from vtbench.validation import every_line
from vtbench.yaml_file import KeyPath, parse_yaml

SUBMISSION_FILE = "submission.yaml"
LARGEST_YAML = 100_000


def read_submission(folder: Path) -> tuple[SubmissionFile | None, list[Problem]]:
    """Return what a folder hands in, and its problems; None where the file itself cannot be understood."""
    path = folder / SUBMISSION_FILE
    if path.is_symlink() or not path.is_file():
        found = f"expected {SUBMISSION_FILE} in {folder.name!r}, found none"
        return None, [Problem("S001", found, "write one; the docs on submitting show an example")]
    if path.stat().st_size > LARGEST_YAML:
        found = f"expected {SUBMISSION_FILE} of {LARGEST_YAML:,} bytes at most, found {path.stat().st_size:,}"
        return None, [Problem("S001", found, "leave out what is not asked for")]
    try:
        file = parse_yaml(path.read_text(encoding="utf-8"), Path(SUBMISSION_FILE))
    except UnicodeDecodeError:
        return None, [Problem("S001", "expected UTF-8 text, found other bytes", "save the file as UTF-8")]
    except (ValueError, RecursionError) as error:
        return None, [Problem("S001", f"expected YAML, found: {error}", "correct that line")]
    return understand(file.data, file.lines)


def understand(data: Mapping[str, Any], lines: Mapping[KeyPath, int]) -> tuple[SubmissionFile | None, list[Problem]]:
    """As `read_submission`, from the mapping that the file holds."""
    try:
        return SubmissionFile.model_validate(data), []
    except pydantic.ValidationError as error:
        return None, [_field(line) for line in every_line(error, SubmissionFile, data, lines)]


def _field(line: str) -> Problem:
    safe = "".join(letter if letter.isprintable() else "?" for letter in line)[:400]
    if "expected plain text" in safe or "expected some text" in safe:
        return Problem("S003", safe, "write it as plain text")
    if "expected an address" in safe:
        return Problem("S004", safe, "give the whole address or leave it out")
    return Problem("S002", safe, "correct that key")


def artifact_path(folder: Path, entry: SubmissionEntry) -> Path | str:
    """The file that an entry names, or why it is not one that may be read: outside the folder, a link, no file."""
    name = entry.model or entry.predictions or ""
    parts = PurePosixPath(name.replace("\\", "/"))
    if parts.is_absolute() or ".." in parts.parts or not parts.parts or "\0" in name:
        return f"expected a file inside the folder, found {name!r}"
    path = folder.joinpath(*parts.parts)
    steps = [folder.joinpath(*parts.parts[: count + 1]) for count in range(len(parts.parts))]
    if any(step.is_symlink() for step in steps):
        return f"expected a file, found that {name!r} is a link"
    if not path.is_file():
        return f"expected the file {name!r}, found none"
    return path
