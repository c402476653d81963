"""The folder of a run: whose it is, and what in it no longer belongs to the suite."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Set
from contextlib import contextmanager
from pathlib import Path

import yaml

from leaderboard.record import RECORD_FILE
from vtbench.data.files import is_temporary, make_folder, remove_temporaries, write_text
from vtbench.run.suite import Suite

SUITE_FILE = "suite.yaml"
SUPERSEDED = "superseded"


@contextmanager
def claim(out: Path, suite: Suite) -> Iterator[None]:
    """Hold `out` for this run of `suite`, with the suite as it was read written into it.

    Raises:
        ValueError: it belongs to another suite, or holds something that is no run.
        OSError: it cannot be written, or another process is running in it.
    """
    path = out / SUITE_FILE
    if path.is_file():
        there = read_suite(out)
        if there.id != suite.id:
            raise ValueError(
                f"{out}: holds a run of the suite {there.id!r}, not of {suite.id!r}; choose another folder"
            )
    elif out.is_dir() and any(not is_temporary(there) for there in out.iterdir()):
        raise ValueError(f"{out}: expected an empty folder or one of an earlier run, found other things in it")
    make_folder(out)
    with _only_run(out):
        for folder in (out, out / "features", *out.glob("runs/*")):
            remove_temporaries(folder)
        write_text(path, yaml.safe_dump(suite.model_dump(mode="json"), sort_keys=False, allow_unicode=True))
        yield


def read_suite(out: Path) -> Suite:
    """The suite that was run in a folder.

    Raises:
        ValueError: no run there, or a suite that this version does not read; one line.
    """
    from vtbench.config import load_model

    path = out / SUITE_FILE
    if not path.is_file():
        raise ValueError(
            f"{out}: expected the folder of a run, found no {SUITE_FILE}; `vtbench run SUITE -o DIR` makes one"
        )
    return load_model(path, Suite)


def set_aside(out: Path, keys: Set[str]) -> int:
    """Move records of cells that the suite no longer has to `superseded/`; returns how many.

    Records of somebody else's models are no cells of the suite, and stay.
    """
    old = [folder for folder in (out / "runs").glob("*") if folder.is_dir() and folder.name not in keys]
    old = [folder for folder in old if not _handed_in(folder / RECORD_FILE)]
    for folder in old:
        target = out / SUPERSEDED / folder.name
        target.parent.mkdir(exist_ok=True)
        number = 0
        while target.exists():
            number += 1
            target = target.with_name(f"{folder.name}.{number}")
        os.replace(folder, target)
    return len(old)


def drop_records(out: Path) -> None:
    """Delete what the suite's cells gave, and nothing else.

    Records of somebody else's models stay, for no run makes them again; so does what cannot be read.
    """
    for folder in (out / "runs").glob("*"):
        if _handed_in(folder / RECORD_FILE) is False:
            shutil.rmtree(folder)


def _handed_in(record: Path) -> bool | None:
    """Whether a record has a submission block; None for one that cannot be read."""
    try:
        return bool(json.loads(record.read_bytes()).get("submission"))
    except (OSError, ValueError, AttributeError):
        return None


@contextmanager
def _only_run(out: Path) -> Iterator[None]:
    """Refuse a second run in the same folder at the same time (no-op where locks do not exist)."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    lock = os.open(out, os.O_RDONLY)
    try:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OSError(f"{out}: another run is at work in this folder; wait until it ends") from None
        yield
    finally:
        os.close(lock)
