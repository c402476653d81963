"""Are a dataset's files those that were written? Sizes and checksums, without looking inside."""

from __future__ import annotations

from pathlib import Path

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
