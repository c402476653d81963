"""`check_dataset`: everything that is wrong with a dataset, one line each, naming shard, row and column."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from vtbench.data.croissant import croissant_problem
from vtbench.data.format import META_FILE, PRESSES, arrow_schema
from vtbench.data.integrity import column_problem, dataset_problems, shard_problem
from vtbench.data.meta import DatasetMeta, ShardEntry, read_meta
from vtbench.data.png import png_problem, png_size
from vtbench.data.slide_checks import onset_problems, state_problems


def check_dataset(path: Path | str) -> list[str]:
    """Problems of the dataset in folder `path`, empty when it is sound.

    Looks at sizes and checksums, then at what the shards hold: columns and their types, finite forces of the
    declared number of taxels, frames of the declared size, labels that fit the classes, ids that are unique.
    """
    folder = Path(path)
    try:
        meta = read_meta(folder)
    except ValueError as error:
        return [str(error)]
    problems = dataset_problems(folder, meta, checksums=True)
    known = {shard.name for shard in meta.shards}
    for stray in sorted(found.name for found in folder.glob("*.parquet") if found.name not in known):
        problems.append(f"{stray}: not one of the shards that {META_FILE} lists")
    ids: Counter[str] = Counter()
    for shard in meta.shards:
        if shard_problem(folder, shard, checksums=False) is None:
            problems += check_shard(folder / shard.name, shard, meta, ids)
    problems += [f"id {name!r} is given to {count} samples" for name, count in ids.items() if count > 1]
    if not problems and (stale := croissant_problem(folder, meta)) is not None:
        problems.append(stale)  # of a damaged dataset it would only say that again
    return problems


def check_shard(path: Path, shard: ShardEntry, meta: DatasetMeta, ids: Counter[str]) -> list[str]:
    """Problems inside one shard; counts its sample ids into `ids`."""
    try:
        table = pq.read_table(path, partitioning=None)
    except (pa.ArrowException, OSError) as error:
        return [f"{path.name}: not readable as Parquet ({' '.join(str(error).split())})"]
    problems = []
    if table.num_rows != shard.rows:
        problems.append(f"{path.name}: {table.num_rows} rows, {META_FILE} says {shard.rows}")
    expected = arrow_schema(meta.columns, meta.n_taxels, meta.truth, meta.classes)
    sound = []
    for field in expected:
        if (problem := column_problem(table.schema, field, path.name)) is not None:
            problems.append(problem)
        else:
            sound.append(field.name)
    names = table["id"].to_pylist() if "id" in sound else [None] * table.num_rows
    ids.update(name for name in names if name is not None)
    for column in sound:
        for what, rows in _cell_problems(table[column].combine_chunks(), column, table, meta):
            if rows.size:
                more = f" (and {rows.size - 1} more rows)" if rows.size > 1 else ""
                where = f"{path.name}, row {rows[0]} (id {names[rows[0]]!r}), column {column!r}"
                problems.append(f"{where}: {what}{more}")
    return problems


def _cell_problems(
    cells: pa.Array, column: str, table: pa.Table, meta: DatasetMeta
) -> Iterator[tuple[str, NDArray[np.int64]]]:
    """(what is wrong, rows where it is) for one column whose type is right."""
    if column == "onset":
        yield from onset_problems(cells, table)
        return
    yield "no value", _rows(cells.is_null())
    if cells.null_count:
        return
    if column in ("image", "image_rest"):
        yield from _image_problems(cells, meta.image_size)
    elif column == "press":
        yield f"expected one of {', '.join(PRESSES)}", _rows(pc.invert(pc.is_in(cells, pa.array(PRESSES))))
    elif column == "label":
        yield from _label_problems(cells, table, meta)
    elif column == "state":
        yield from state_problems(cells, table)
    elif column == "frames":
        for row, rows_frames in enumerate(cells):
            for what, _ in _image_problems(rows_frames.values, meta.image_size):
                yield what, np.array([row])
    elif column == "hold_stop":
        yield from _hold_problems(cells, table)
    else:
        yield from _finite_problems(cells)


def _image_problems(cells: pa.Array, size: tuple[int, int]) -> Iterator[tuple[str, NDArray[np.int64]]]:
    found: dict[str, list[int]] = {}
    for row, data in enumerate(cells.field("bytes").to_pylist()):
        problem = png_problem(data)
        if problem is None and (there := png_size(data)) != size:
            problem = f"frame of {there[0]}x{there[1]} pixels, expected {size[0]}x{size[1]} (height x width)"
        if problem is not None:
            found.setdefault(problem, []).append(row)
    for problem, rows in found.items():
        yield problem, np.array(rows)


def _label_problems(cells: pa.Array, table: pa.Table, meta: DatasetMeta) -> Iterator[tuple[str, NDArray[np.int64]]]:
    label = cells.to_numpy()
    inside = (label >= 0) & (label < len(meta.classes))
    yield f"outside 0..{len(meta.classes) - 1}", np.flatnonzero(~inside)
    if "object" in table.column_names:
        objects = table["object"].to_pylist()
        wrong = [r for r in np.flatnonzero(inside) if meta.classes[label[r]] != objects[r]]
        yield "not the label of the row's object", np.array(wrong, np.int64)


def _hold_problems(cells: pa.Array, table: pa.Table) -> Iterator[tuple[str, NDArray[np.int64]]]:
    if not {"hold_start", "force_series"} <= set(table.column_names):
        return
    start, stop = table["hold_start"].to_numpy(), cells.to_numpy()
    length = pc.list_value_length(table["force_series"]).to_numpy()
    good = (start >= 0) & (start < stop) & (stop <= length)
    yield "the hold is empty or lies outside force_series", np.flatnonzero(~good)


def _finite_problems(cells: pa.Array) -> Iterator[tuple[str, NDArray[np.int64]]]:
    """Rows with a NaN or an infinity, whatever the nesting of the column."""
    row = np.arange(len(cells))
    width = 1
    while pa.types.is_list(cells.type) or pa.types.is_fixed_size_list(cells.type):
        if pa.types.is_list(cells.type):
            row, width = np.repeat(row, cells.value_lengths().to_numpy()), 1
        else:
            width = cells.type.list_size
            row = np.repeat(row, width)
        cells = cells.flatten()
    if not pa.types.is_floating(cells.type):
        return
    bad = np.flatnonzero(~np.isfinite(cells.to_numpy(zero_copy_only=False)))
    where = f" at taxel {bad[0] % width}" if bad.size and width > 1 else ""
    yield f"not finite{where}", np.unique(row[bad])


def _rows(mask: pa.Array) -> NDArray[np.int64]:
    rows: NDArray[np.int64] = np.flatnonzero(mask.to_numpy(zero_copy_only=False))
    return rows
