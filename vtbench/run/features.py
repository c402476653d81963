"""Features on disk, under the hash of what they come from; computed in chunks, one process a core."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vtbench.data.files import write_text, write_whole
from vtbench.data.shards import one_thread
from vtbench.run.progress import bar
from vtbench.scheduling import Cluster
from vtbench.tasks.base import Features

CHUNK = 54


class DiskFeatures:
    """A cache of feature matrices below a folder.

    Args:
        folder: created when something is kept.
        jobs: processes that compute.
        progress: show a bar.
        cluster: workers elsewhere that compute instead.
    """

    def __init__(self, folder: Path, jobs: int = 1, progress: bool = False, cluster: Cluster | None = None) -> None:
        self.folder = folder
        self.jobs = jobs
        self.progress = progress
        self.cluster = cluster

    def cached(self, identity: Mapping[str, str], n: int, compute: Callable[[NDArray[np.int64]], Features]) -> Features:
        """Features (n, columns) float32, read where they were kept before, else computed and kept.

        Args:
            identity: what decides them; its hash names the file.
            n: number of rows.
            compute: row indices -> features; picklable.
        """
        path = self._path(identity)
        if path.is_file() and path.with_suffix(".json").is_file():
            kept = _kept(path)
            if kept is not None and len(kept) == n:
                return kept
        features, us_per_sample = self._compute(identity, n, compute)
        self.folder.mkdir(parents=True, exist_ok=True)
        note = {**identity, "rows": n, "us_per_sample": us_per_sample}
        write_text(path.with_suffix(".json"), json.dumps(note, indent=1) + "\n")
        write_whole(path, partial(_save, features))
        return features

    def us_per_sample(self, identity: Mapping[str, str]) -> float | None:
        """What computing them took a sample, microseconds on one thread; None where they are not kept."""
        note = self._path(identity).with_suffix(".json")
        return float(json.loads(note.read_text())["us_per_sample"]) if note.is_file() else None

    def _path(self, identity: Mapping[str, str]) -> Path:
        name = hashlib.sha256(json.dumps(dict(identity), sort_keys=True).encode()).hexdigest()[:32]
        return self.folder / f"{name}.npy"

    def _compute(
        self, identity: Mapping[str, str], n: int, compute: Callable[[NDArray[np.int64]], Features]
    ) -> tuple[Features, float]:
        chunks = [np.arange(start, min(start + CHUNK, n)) for start in range(0, n, CHUNK)]
        label = " ".join(["features", *(identity[key] for key in ("backbone", "frames") if key in identity)])
        parts: list[Features] = []
        seconds: list[float] = []
        with bar(n, label, self.progress) as advance:
            for part, spent in self._results(compute, chunks):
                parts.append(part)
                seconds.append(spent / len(part))
                advance(len(part))
        # the first chunk of a process loads the network: the median leaves that out
        return np.concatenate(parts).astype(np.float32, copy=False), float(np.median(seconds)) * 1e6

    def _results(
        self, compute: Callable[[NDArray[np.int64]], Features], chunks: list[NDArray[np.int64]]
    ) -> Iterator[tuple[Features, float]]:
        """Features of each chunk and the seconds they took, in the order of the chunks."""
        from joblib import Parallel, delayed, parallel_config

        if self.cluster is not None:
            yield from self.cluster.in_order(partial(_timed_alone, compute), chunks)
            return
        backend = {"backend": "loky", "inner_max_num_threads": 1} if self.jobs > 1 else {"backend": "sequential"}
        with parallel_config(**backend):
            yield from Parallel(n_jobs=self.jobs, return_as="generator")(delayed(_timed)(compute, c) for c in chunks)


def _timed_alone(compute: Callable[[NDArray[np.int64]], Features], rows: NDArray[np.int64]) -> tuple[Features, float]:
    """As `_timed`, numerical libraries on one thread."""
    with one_thread():
        return _timed(compute, rows)


def _timed(compute: Callable[[NDArray[np.int64]], Features], rows: NDArray[np.int64]) -> tuple[Features, float]:
    start = time.perf_counter()
    features = compute(rows)
    return features, time.perf_counter() - start


def _kept(path: Path) -> Features | None:
    """Features of a file; None where it is damaged, so that they are computed again."""
    try:
        kept: Features = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, EOFError):
        return None
    return kept


def _save(features: Features, path: Path) -> None:
    with path.open("wb") as file:
        np.save(file, features, allow_pickle=False)
