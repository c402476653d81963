"""Rows of Python values and arrays -> Arrow table -> Parquet file, the same bytes every time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

Row = Mapping[str, Any]

_TEXT = ("object", "press", "kind")


def build_table(rows: Sequence[Row], schema: pa.Schema) -> pa.Table:
    """Table of `schema` with one row per mapping; images are (bytes, path) pairs, lists are arrays."""
    columns = [_array([row[field.name] for row in rows], field.type) for field in schema]
    return pa.Table.from_arrays(columns, schema=schema)


def write_parquet(table: pa.Table, path: Path) -> None:
    """Write one row group, zstd; nothing in the file depends on time, place or number of workers."""
    pq.write_table(
        table,
        path,
        compression="zstd",
        compression_level=3,
        row_group_size=max(1, table.num_rows),
        use_dictionary=list(_TEXT),
        write_statistics=False,
        version="2.6",
    )


def _array(values: list[Any], kind: pa.DataType) -> pa.Array:
    if pa.types.is_struct(kind):
        data, paths = zip(*values, strict=True) if values else ((), ())
        return pa.StructArray.from_arrays(
            [pa.array(data, pa.binary()), pa.array(paths, pa.string())], fields=list(kind)
        )
    if pa.types.is_fixed_size_list(kind):
        stacked = np.stack([np.asarray(value) for value in values])
        return _fixed(stacked.reshape(-1), kind)
    if pa.types.is_list(kind) and pa.types.is_struct(kind.value_type):
        offsets = np.cumsum([0, *map(len, values)], dtype=np.int32)
        items = _array([cell for cells in values for cell in cells], kind.value_type)
        return pa.ListArray.from_arrays(pa.array(offsets), items, type=kind)
    if pa.types.is_list(kind):
        arrays = [np.asarray(value) for value in values]
        offsets = np.cumsum([0, *(len(array) for array in arrays)], dtype=np.int32)
        items = _fixed(np.concatenate(arrays).reshape(-1), kind.value_type)
        return pa.ListArray.from_arrays(pa.array(offsets), items, type=kind)
    return pa.array(values, kind)


def _fixed(flat: np.ndarray[Any, Any], kind: pa.DataType) -> pa.Array:
    """Nested fixed-size lists around a flat array, innermost first."""
    if not pa.types.is_fixed_size_list(kind):
        return pa.array(flat, kind)
    return pa.FixedSizeListArray.from_arrays(_fixed(flat, kind.value_type), type=kind)
