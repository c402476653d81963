"""Predictions that were handed in: a CSV or NumPy file -> arrays, every value checked."""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

LARGEST_BYTES = 200 * 2**20
_COLUMNS = ("sample_id", "label", "fold")
_ARRAYS = (*_COLUMNS, "scores")


@dataclass(frozen=True)
class Predicted:
    """One prediction a row: sample ids, labels as text (a class name or its index), fold names ('' without)."""

    ids: NDArray[np.str_]
    labels: NDArray[np.str_]
    folds: NDArray[np.str_]


def read_predictions_file(path: Path) -> Predicted:
    """Read a .csv with the columns sample_id, label and maybe fold, or an .npz with arrays of these names or `scores`.

    Raises:
        ValueError: too large, not readable, columns missing, scores that are not finite, a sample twice in a fold.
    """
    if path.stat().st_size > LARGEST_BYTES:
        raise ValueError(f"expected {LARGEST_BYTES >> 20} MB at most, found {path.stat().st_size >> 20} MB")
    if path.suffix not in (".csv", ".npz"):
        raise ValueError(f"expected a file that ends in .csv or .npz, found {path.suffix or 'no ending'!r}")
    columns = _csv(path) if path.suffix == ".csv" else _npz(path)
    ids = columns["sample_id"]
    folds = columns.get("fold", np.full(len(ids), ""))
    pairs, counts = np.unique(np.stack([ids, folds]), axis=1, return_counts=True)
    if (counts > 1).any():
        twice = str(pairs[0, counts.argmax()])[:60]
        raise ValueError(f"expected each sample once a fold, found {twice!r} {counts.max()} times")
    return Predicted(ids, columns["label"], folds)


def _csv(path: Path) -> dict[str, NDArray[np.str_]]:
    try:
        text = path.read_text(encoding="utf-8-sig")
        rows = list(csv.reader(io.StringIO(text), strict=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"expected CSV in UTF-8, found: {error}") from None
    head = [name.strip() for name in rows[0]] if rows else []
    _need(head, ("sample_id", "label"), _COLUMNS)
    body = [row for row in rows[1:] if row]
    for number, row in enumerate(body, start=2):
        if len(row) != len(head):
            raise ValueError(f"line {number}: expected {len(head)} values, found {len(row)}")
    if not body:
        raise ValueError("expected at least one prediction, found none")
    return {name: np.array([row[at].strip() for row in body]) for at, name in enumerate(head)}


def _npz(path: Path) -> dict[str, NDArray[np.str_]]:
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(member.file_size for member in archive.infolist())
        if size > LARGEST_BYTES:
            raise ValueError(f"expected {LARGEST_BYTES >> 20} MB unpacked at most, found {size >> 20} MB")
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays: dict[str, NDArray[Any]] = {name: archive[name] for name in archive.files}
    except (zipfile.BadZipFile, OSError, EOFError, KeyError, MemoryError) as error:
        raise ValueError(f"expected NumPy arrays without pickle, found: {error}") from None
    _need(list(arrays), ("sample_id",), _ARRAYS)
    if "scores" in arrays:
        arrays["label"] = _best(arrays.pop("scores"))
    _need(list(arrays), ("sample_id", "label"), _ARRAYS)
    shapes = {array.shape for array in arrays.values()}
    if len(shapes) != 1 or len(next(iter(shapes))) != 1 or not next(iter(shapes))[0]:
        raise ValueError(f"expected arrays of one length, found shapes {sorted(map(str, shapes))}")
    return {name: array.astype(np.str_) for name, array in arrays.items()}


def _best(scores: NDArray[Any]) -> NDArray[np.int64]:
    if scores.ndim != 2 or scores.dtype.kind != "f" or not scores.shape[1]:
        raise ValueError(f"scores: expected (n, classes) floats, found {scores.dtype} {scores.shape}")
    if not np.isfinite(scores).all():
        bad = int((~np.isfinite(scores).all(1)).sum())
        raise ValueError(f"scores: expected finite numbers, found {bad} of {len(scores)} rows with NaN or infinity")
    return scores.argmax(1)


def _need(found: Sequence[str], needed: Sequence[str], known: Sequence[str]) -> None:
    from vtbench.registry import hint

    for name in needed:
        if name not in found:
            raise ValueError(f"expected the column {name!r}, found {', '.join(map(repr, found[:6])) or 'none'}")
    for name in found:
        if name not in known:
            raise ValueError(f"unknown column {name[:40]!r}{hint(name, known)}")
    if len(set(found)) != len(found):
        raise ValueError(f"expected each column once, found {', '.join(found[:6])}")


def class_indices(labels: NDArray[np.str_], classes: Sequence[str]) -> NDArray[np.int32]:
    """Labels as class indices, from names or from numbers.

    Raises:
        ValueError: a label that is neither.
    """
    places: Mapping[str, int] = {str(at): at for at in range(len(classes))} | {c: at for at, c in enumerate(classes)}
    found = [places.get(label, -1) for label in labels.tolist()]
    if -1 in found:
        wrong = str(labels[found.index(-1)])[:40]
        raise ValueError(f"expected a class name or 0..{len(classes) - 1} as label, found {wrong!r}")
    return np.array(found, np.int32)
