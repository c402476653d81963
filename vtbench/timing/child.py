"""One process of a timing: load a subject, warm up, time it, print every sample as JSON.

`python -m vtbench.timing.child` reads `{"out", "key", "kind", "block", "count"}` on standard input.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

WARM_UP_S = 0.2
ONE_CALLS, ONE_S = 300, 1.0
MANY_CALLS, MANY_S = 20, 1.5
LEAST_CALLS = 5


def measure(call: Callable[[int], object], n: int, most: int, seconds: float) -> list[int]:
    """Nanoseconds of each call on rotating samples, for so many calls or seconds, at least `LEAST_CALLS`."""
    taken: list[int] = []
    began = time.perf_counter()
    while len(taken) < most and (len(taken) < LEAST_CALLS or time.perf_counter() - began < seconds):
        row = len(taken) % n
        start = time.perf_counter_ns()
        call(row)
        taken.append(time.perf_counter_ns() - start)
    return taken


def main() -> None:
    """Time what standard input names."""
    asked = json.loads(sys.stdin.read())
    began = time.perf_counter()
    from threadpoolctl import threadpool_limits

    from vtbench.run.folder import read_suite
    from vtbench.run.planned import planned
    from vtbench.timing import ready

    imported = time.perf_counter()
    out = Path(asked["out"])
    suite = read_suite(out)
    (cell,) = [cell for cell in planned(suite, out) if cell.key == asked["key"]]
    with threadpool_limits(1):
        subject = {
            "features": lambda: ready.load_features(cell, suite, out, asked["block"]),
            "classifier": lambda: ready.load_classifier(cell, suite, out),
            "detector": lambda: ready.load_detector(cell, suite, out),
        }[asked["kind"]]()
        loaded = time.perf_counter()
        before = _peak_mb()
        start = time.perf_counter_ns()
        subject.one(0)
        first = time.perf_counter_ns() - start
        measure(subject.one, subject.n, ONE_CALLS, WARM_UP_S)
        one = measure(subject.one, subject.n, ONE_CALLS, ONE_S)
        subject.many(0)
        many = measure(subject.many, subject.n, MANY_CALLS, MANY_S)
        peak = _peak_mb()
    result: dict[str, Any] = {
        "import_s": imported - began,
        "load_s": loaded - imported,
        "first_call_ns": first,
        "one_ns": one,
        "many_ns": many,
        "large": subject.large,
        "peak_mb_loaded": before,
        "peak_mb": peak,
    }
    if asked["count"]:  # last, so that building a graph is in no figure above
        result["graph"] = _counted(subject.count)
    print(json.dumps(result))


def _counted(count: Callable[[], Any]) -> dict[str, int | None] | None:
    """Counts of a subject's graph; None where it has none. A count that fails costs no timing."""
    try:
        found = count()
    except Exception:  # exporters, checkers and shape inference of three libraries
        return None
    return None if found is None else asdict(found)


def _peak_mb() -> float:
    from fusion.peak_memory import peak_resident_bytes

    return peak_resident_bytes() / 2**20


if __name__ == "__main__":
    main()
