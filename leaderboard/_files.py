"""Records on disk: `DIR/runs/<key>/{record.json, predictions.npz}`, whole or absent, and no pickle."""

from __future__ import annotations

import json
import os
import warnings
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from leaderboard._models import Record

RECORD_FILE = "record.json"
PREDICTIONS_FILE = "predictions.npz"
TALLY_FILE = "tally.json"

Arrays = dict[str, NDArray[Any]]


class RecordWarning(UserWarning):
    """A record could not be read and is left out; the message names its file."""


def write_record(run_dir: Path, record: Record, predictions: Mapping[str, NDArray[Any]] | None = None) -> Path:
    """Write a record, and its predictions where given, under `run_dir/runs/<key>` and return that folder.

    Each file is written under a temporary name, flushed and renamed, predictions first: where a record can be
    read, its predictions are whole. Without `predictions` those already there stay, so that a score can be taken
    again; a record that is not "ok" removes them. ValueError for arrays that would need pickle.
    """
    folder = _root(run_dir, writing=True) / record.key
    arrays = {name: _plain(name, array) for name, array in (predictions or {}).items()}
    folder.mkdir(parents=True, exist_ok=True)
    if arrays or record.status.state != "ok":
        (folder / TALLY_FILE).unlink(missing_ok=True)  # it counted other predictions
    if arrays:
        write_atomic(folder / PREDICTIONS_FILE, arrays)
    elif record.status.state != "ok":
        (folder / PREDICTIONS_FILE).unlink(missing_ok=True)
    text = json.dumps(record.model_dump(mode="json"), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    write_atomic(folder / RECORD_FILE, text.encode())
    return folder


def read_records(run_dir: Path) -> list[Record]:
    """Return the records under `run_dir`, by key; each that cannot be read is one `RecordWarning`, the rest stand."""
    records, problems = scan_records(run_dir)
    for problem in problems:
        warnings.warn(problem, RecordWarning, stacklevel=2)
    return records


def scan_records(run_dir: Path) -> tuple[list[Record], list[str]]:
    """Return the records under `run_dir`, by key, and one line for each file that cannot be read.

    `run_dir` is a run's folder or its `runs` folder. ValueError when it does not exist.
    """
    records: list[Record] = []
    problems: list[str] = []
    for path in sorted(_root(run_dir).glob(f"*/{RECORD_FILE}")):
        try:
            records.append(_read(path))
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"]) or "record"
            more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
            problems.append(f"{path}: left out: {where}: {first['msg']}{more}")
        except (ValueError, OSError) as error:
            problems.append(f"{path}: left out: {error}")
    return records, problems


def read_predictions(run_dir: Path, key: str) -> Arrays:
    """Return a record's prediction arrays by name; ValueError naming the file when it is missing or broken."""
    path = _root(run_dir) / key / PREDICTIONS_FILE
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except FileNotFoundError:
        raise ValueError(f"{path}: expected the predictions of this record, found none; run the cell again") from None
    except (ValueError, OSError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path}: expected NumPy arrays without pickle, got a broken file ({error})") from error


def has_predictions(run_dir: Path, key: str) -> bool:
    """Whether a record's prediction file is there and an archive to its end; its arrays are not read."""
    return zipfile.is_zipfile(_root(run_dir, writing=True) / key / PREDICTIONS_FILE)


def _read(path: Path) -> Record:
    record = Record.model_validate_json(path.read_bytes())
    if record.key != path.parent.name:
        raise ValueError(f"key {record.key[:12]}... does not match its folder's name")
    return record


def _root(run_dir: Path, writing: bool = False) -> Path:
    run_dir = Path(run_dir)
    if writing or (run_dir / "runs").is_dir():
        return run_dir / "runs"
    if not run_dir.is_dir():
        raise ValueError(f"{run_dir}: expected a folder of records, found none; `vtbench run SUITE -o DIR` makes one")
    return run_dir


def _plain(name: str, array: NDArray[Any]) -> NDArray[Any]:
    array = np.asarray(array)
    if array.dtype.hasobject:
        raise ValueError(f"predictions '{name}': expected numbers, booleans or fixed-width text, got {array.dtype}")
    return array


def write_atomic(path: Path, content: bytes | Arrays) -> None:
    """Write a file under a temporary name, flush it and rename it: readers see the old file or the new one."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with open(temporary, "wb") as file:
            _fill(file, content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        reason = str(error) if error.errno is None else os.strerror(error.errno)
        raise OSError(f"{path}: cannot be written ({reason}); what was there is as it was") from error
    finally:
        temporary.unlink(missing_ok=True)
    _sync_folder(path.parent)


def _fill(file: IO[bytes], content: bytes | Arrays) -> None:
    if isinstance(content, bytes):
        file.write(content)
    else:
        np.savez_compressed(file, **content)  # type: ignore[arg-type]  # names are free


def _sync_folder(folder: Path) -> None:
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
