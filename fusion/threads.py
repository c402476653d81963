"""Threads over chunks of queries, for work that releases the interpreter's lock."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")


def count_threads(n_jobs: int | None) -> int:
    """Threads that `n_jobs` means: None is 1, negative numbers count from all cores, as in joblib."""
    if n_jobs is None:
        return 1
    from joblib import effective_n_jobs

    return int(effective_n_jobs(n_jobs))


def map_threads(function: Callable[[T], R], items: Iterable[T], n_jobs: int | None) -> list[R]:
    """[function(item) for item in items], over `n_jobs` threads."""
    threads = count_threads(n_jobs)
    if threads == 1:
        return [function(item) for item in items]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, items))
