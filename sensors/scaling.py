"""How much faster two processes press than one."""

from __future__ import annotations

import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

PRESSES = 54
"""Presses of each process in a round."""


def two_processes(rounds: int = 3, presses: int = PRESSES) -> dict[str, Any]:
    """Presses a second of two processes over those of one, both pinned to one thread: median and range of the rounds.

    One process and two take turns, each with warm caches; about ten seconds. Other load on the machine shows.
    """
    if rounds < 1:
        raise ValueError(f"rounds must be >= 1, got {rounds}")
    ratios = []
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        list(pool.map(_press_all, (presses, presses)))  # a pool starts a worker for each task that waits
        for _ in range(rounds):
            alone = _wall(pool, (presses,))
            both = _wall(pool, (presses, presses))
            ratios.append(2 * alone / both)
    return {
        "ratio": float(np.median(ratios)),
        "low": min(ratios),
        "high": max(ratios),
        "rounds": rounds,
        "presses": presses,
    }


def _wall(pool: ProcessPoolExecutor, shares: tuple[int, ...]) -> float:
    start = time.perf_counter()
    list(pool.map(_press_all, shares))
    return time.perf_counter() - start


def _press_all(presses: int) -> int:
    from threadpoolctl import threadpool_limits

    from sensors.press import simulate
    from sensors.scene import PressScene

    scene = PressScene(id="scaling", title="scaling")
    with threadpool_limits(1):
        for index in range(presses):
            simulate(scene, index % len(scene.object_names), 0)
    return presses
