"""Are a dataset's files those that were written? Sizes, checksums and column types, no values."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa

from vtbench.data.files import sha256_of
from vtbench.data.meta import DatasetMeta, ShardEntry, content_hash


def dataset_problems(folder: Path, meta: DatasetMeta, *, checksums: bool) -> list[str]:
    """One line for each shard that is missing, truncated or changed, or that `dataset.json` contradicts."""
    problems = []
    if [shard.rows for shard in meta.shards] != [len(meta.shard_rows(i)) for i in range(meta.n_shards)]:
        problems.append(f"dataset.json: the shards' rows do not add up to its {meta.samples} samples")
    if meta.hash != content_hash(meta, meta.shards):
        problems.append("dataset.json: its hash does not belong to its shards")
    for shard in meta.shards:
        if (problem := shard_problem(folder, shard, checksums=checksums)) is not None:
            problems.append(problem)
    return problems


def shard_problem(folder: Path, shard: ShardEntry, *, checksums: bool) -> str | None:
    """What is wrong with one shard's file, in one line that names it; None when nothing is."""
    path = folder / shard.name
    if not path.is_file():
        return f"{shard.name}: missing"
    size = path.stat().st_size
    if size < shard.bytes:
        return f"{shard.name}: truncated: {size:,} bytes of {shard.bytes:,}"
    if size > shard.bytes:
        return f"{shard.name}: {size:,} bytes, expected {shard.bytes:,}"
    if checksums and (found := sha256_of(path)) != shard.sha256:
        return f"{shard.name}: checksum is off: SHA-256 {found[:12]}..., expected {shard.sha256[:12]}..."
    return None


def column_problem(schema: pa.Schema, expected: pa.Field, shard: str) -> str | None:
    """How a shard's column differs from what was declared, in one line that names both; None when it fits."""
    if expected.name not in schema.names:
        return f"{shard}: column {expected.name!r} is missing"
    found, wanted = schema.field(expected.name).type, expected.type
    if found == wanted:
        return None
    where = f"{shard}, column {expected.name!r}"
    inner, size = (kind.value_type if pa.types.is_list(kind) else kind for kind in (found, wanted))
    forces = pa.types.is_fixed_size_list(inner) and not expected.name.startswith("truth_")
    if forces and inner.list_size != size.list_size:
        return f"{where}: {inner.list_size} taxels, expected {size.list_size}"
    return f"{where}: type {found}, expected {wanted}"
