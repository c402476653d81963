"""Shards in parallel: whole or absent, resumed after a kill, the same bytes for any number of processes."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pyarrow as pa

from vtbench.data.croissant import croissant_problem, croissant_text
from vtbench.data.files import (
    make_folder,
    only_writer,
    remove_temporaries,
    sha256_of,
    write_text,
    write_whole,
)
from vtbench.data.format import CROISSANT_FILE, META_FILE, PARTIAL_FILE, arrow_schema, shard_name
from vtbench.data.meta import DatasetMeta, Plan, Progress, ShardEntry, first_difference, read_meta, read_model
from vtbench.data.table import Row, build_table, write_parquet
from vtbench.interruption import raise_interruption
from vtbench.scheduling import Cluster, Died

RowMaker = Callable[[int], Row]


class SampleError(ValueError):
    """A sample that cannot be made: the fault is in what was asked for, not in the folder."""


def write_shards(
    out: Path,
    plan: Plan,
    make_row: RowMaker,
    *,
    jobs: int,
    cluster: Cluster | None = None,
    progress: bool = True,
    resume: bool = True,
) -> Path:
    """Write the dataset that `plan` describes, `make_row(index)` giving each of its rows.

    Shards that an earlier call with the same plan finished are kept when their checksum still holds; with
    `resume=False` everything is written anew. `make_row` must depend on nothing but the index, and be
    picklable when `jobs` > 1 or there is a `cluster`, whose workers need not see `out`. Finished shards stay when
    anything fails.

    Raises:
        ValueError: the folder holds something else or another plan, or a row cannot be made (it is named).
        OSError: the disk refuses, a worker process died, or another process writes here.
    """
    make_folder(out)
    with only_writer(out):
        remove_temporaries(out)
        if not resume:
            _clear(out)
        done = {entry.name: entry for entry in _kept(out, plan)}
        todo = [number for number in range(plan.n_shards) if shard_name(number) not in done]
        if not todo and (out / META_FILE).is_file():
            if croissant_problem(out, meta := read_meta(out)):
                write_text(out / CROISSANT_FILE, croissant_text(meta))
            return out
        _save(out / PARTIAL_FILE, Progress(plan=plan, shards=_in_order(done.values())))
        (out / META_FILE).unlink(missing_ok=True)
        try:
            with _bar(plan, done.values(), progress) as advance:
                for entry in _run(out, plan, make_row, todo, jobs, cluster):
                    done[entry.name] = entry
                    _save(out / PARTIAL_FILE, Progress(plan=plan, shards=_in_order(done.values())))
                    advance(entry.rows)
        finally:
            remove_temporaries(out)
        meta = DatasetMeta.of(plan, _in_order(done.values()))
        write_text(out / CROISSANT_FILE, croissant_text(meta))
        _save(out / META_FILE, meta)
        (out / PARTIAL_FILE).unlink(missing_ok=True)
    return out


def _kept(out: Path, plan: Plan) -> Iterator[ShardEntry]:
    """Shards of an earlier call that are whole; ValueError when the folder holds something else."""
    if (out / META_FILE).is_file():
        meta = read_meta(out)
        earlier = Progress(plan=meta.plan, shards=meta.shards)
    elif (out / PARTIAL_FILE).is_file():
        earlier = read_model(out / PARTIAL_FILE, Progress)
    elif any(out.iterdir()):
        raise ValueError(f"{out}: not empty and holds no dataset; choose a new or empty folder")
    else:
        return
    there, asked = earlier.plan.model_dump(mode="json"), plan.model_dump(mode="json")
    if difference := first_difference(there, asked):
        raise ValueError(f"{out}: holds another dataset ({difference}); choose a new folder or delete this one")
    for entry in earlier.shards:
        path = out / entry.name
        if path.is_file() and sha256_of(path) == entry.sha256:
            yield entry


def _write_shard(out: Path, plan: Plan, make_row: RowMaker, number: int) -> ShardEntry:
    return _put(out, _shard(plan, make_row, number), number)


def _shard(plan: Plan, make_row: RowMaker, number: int) -> pa.Table:
    """The rows of one shard."""
    parent = os.getppid()
    rows: list[Row] = []
    with one_thread():
        for index in plan.shard_rows(number):
            if os.getppid() != parent:
                raise SystemExit("the process that asked for this shard is gone")
            with naming_sample(plan.name, index):
                rows.append(make_row(index))
        return build_table(rows, arrow_schema(plan.columns, plan.n_taxels, plan.truth, plan.classes))


@contextmanager
def naming_sample(dataset: str, index: int) -> Iterator[None]:
    """Any failure but the system's as a `SampleError` that names dataset and sample; an interruption goes through."""
    try:
        yield
    except OSError:
        raise
    except Exception as error:
        raise_interruption(error)
        raise SampleError(f"{dataset}, sample {index}: {_one_line(error)}") from error


def _put(out: Path, table: pa.Table, number: int) -> ShardEntry:
    """Write the rows of one shard to the disk."""
    path = out / shard_name(number)
    write_whole(path, partial(write_parquet, table))
    return ShardEntry(name=path.name, rows=table.num_rows, bytes=path.stat().st_size, sha256=sha256_of(path))


def _run(
    out: Path, plan: Plan, make_row: RowMaker, todo: list[int], jobs: int, cluster: Cluster | None
) -> Iterator[ShardEntry]:
    work = partial(_write_shard, out, plan, make_row)
    if cluster is not None:
        for place, table in cluster.map(partial(_shard, plan, make_row), todo):
            if isinstance(table, Died):
                raise OSError(f"{plan.name}, shard {todo[place]}: {table.reason}; finished shards are kept")
            yield _put(out, table, todo[place])
        return
    if jobs == 1 or len(todo) <= 1:
        yield from map(work, todo)
        return
    from joblib import Parallel, delayed

    try:
        parallel = Parallel(n_jobs=jobs, prefer="processes", return_as="generator_unordered")
        yield from parallel(delayed(work)(number) for number in todo)
    except BrokenProcessPool as error:
        raise OSError(
            "a worker process died (killed, or out of memory); finished shards are kept: run the same "
            "command again, with fewer jobs if memory is short"
        ) from error


@contextmanager
def one_thread() -> Iterator[None]:
    """Numerical libraries on one thread: `jobs` processes use `jobs` cores, and sums always have one order.

    With more threads BLAS adds in another order, and the last bits of a recording differ.
    """
    import cv2
    import scipy.linalg  # noqa: F401  only a library that is loaded can be limited
    from threadpoolctl import threadpool_limits

    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        with threadpool_limits(1):
            yield
    finally:
        cv2.setNumThreads(before)


@contextmanager
def _bar(plan: Plan, done: Iterable[ShardEntry], show: bool) -> Iterator[Callable[[int], object]]:
    from tqdm import tqdm

    kept = sum(entry.rows for entry in done)
    hidden = None if show else True  # None: shown on a terminal only
    with tqdm(total=plan.samples, initial=kept, desc=plan.name, unit="sample", file=sys.stderr, disable=hidden) as bar:
        yield bar.update


def _in_order(entries: Iterable[ShardEntry]) -> tuple[ShardEntry, ...]:
    return tuple(sorted(entries, key=lambda entry: entry.name))


def _save(path: Path, model: Progress | DatasetMeta) -> None:
    write_text(path, model.model_dump_json(indent=1) + "\n")


def _clear(out: Path) -> None:
    """Remove what a dataset consists of, and nothing else."""
    for path in (*out.glob("shard-*.parquet"), *(out / name for name in (META_FILE, PARTIAL_FILE, CROISSANT_FILE))):
        path.unlink(missing_ok=True)


def _one_line(error: Exception) -> str:
    text = " ".join(str(error).split())
    return text if isinstance(error, ValueError) and text else f"{type(error).__name__}: {text}"
