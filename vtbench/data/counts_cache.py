"""Many small CSV files of whole numbers -> one array, quickly, and quicker the second time."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import csv

from vtbench.data.files import write_whole
from vtbench.data.format import canonical_json
from vtbench.paths import cache_dir


def cached_counts(
    name: str, root: Path, paths: Sequence[str], columns: Sequence[str]
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """`read_counts`, kept in the cache under `name` for as long as the files' sizes and times stay the same."""
    key = _key(root, paths)
    cache = cache_dir() / "parsed" / f"{name}.npz"
    damaged = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile)
    with suppress(*damaged), cache.open("rb") as file, np.load(file) as stored:
        if str(stored["key"]) == key:
            return stored["rows"], stored["counts"]
    rows, counts = read_counts(root, paths, columns)
    with suppress(OSError):  # a cache that cannot be written costs time, nothing else
        cache.parent.mkdir(parents=True, exist_ok=True)
        data = io.BytesIO()
        np.savez(data, key=np.array(key), rows=rows, counts=counts)
        write_whole(cache, lambda temporary: temporary.write_bytes(data.getbuffer()))
    return rows, counts


def read_counts(
    root: Path, paths: Sequence[str], columns: Sequence[str]
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Rows of each file (n,), and all rows below each other (sum, columns) int32.

    Raises:
        ValueError: a file with other columns or a cell that is no whole number; the file is named.
    """
    bodies = [_body(root / path, columns) for path in paths]
    try:
        counts = _parse(b"".join(bodies), len(columns))
    except pa.ArrowInvalid:
        for path, body in zip(paths, bodies, strict=True):
            try:
                _parse(body, len(columns))
            except pa.ArrowInvalid as error:
                raise ValueError(f"{root / path}: {' '.join(str(error).split())}") from error
        raise
    return np.array([body.count(b"\n") for body in bodies]), counts


def _body(path: Path, columns: Sequence[str]) -> bytes:
    """The lines below the heading, each ended by a newline."""
    heading, _, body = path.read_bytes().replace(b"\r\n", b"\n").partition(b"\n")
    found = [name.strip() for name in heading.decode("utf-8", "replace").split(",")]
    if found != list(columns):
        raise ValueError(f"{path}: expected the columns {', '.join(columns)}, got {', '.join(found)}")
    body = body.rstrip(b"\n")
    if not body:
        raise ValueError(f"{path}: no samples below the heading")
    return body + b"\n"


def _parse(body: bytes, n_columns: int) -> NDArray[np.int32]:
    names = [str(number) for number in range(n_columns)]
    table = csv.read_csv(
        pa.BufferReader(body),
        read_options=csv.ReadOptions(column_names=names, use_threads=False),
        parse_options=csv.ParseOptions(ignore_empty_lines=False),
        convert_options=csv.ConvertOptions(column_types=dict.fromkeys(names, pa.int32()), null_values=[]),
    )
    counts = np.empty((table.num_rows, n_columns), np.int32)
    for number, column in enumerate(table.columns):
        counts[:, number] = column.to_numpy()
    return counts


def _key(root: Path, paths: Sequence[str]) -> str:
    stats = [(path, (root / path).stat()) for path in paths]
    known = [[path, stat.st_size, stat.st_mtime_ns] for path, stat in stats]
    return hashlib.sha256(canonical_json([str(root.resolve()), known]).encode()).hexdigest()
