"""Peak memory of `KSC.predict`, in a process of its own: `python -m fusion.peak_memory QUERIES ATOMS THREADS`."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np


def peak_memory(n_queries: int, n_atoms: int, n_jobs: int) -> dict[str, float]:
    """Peak resident bytes and seconds of predicting `n_queries` against `n_atoms` in 28 columns, by a child."""
    command = [sys.executable, "-m", "fusion.peak_memory", str(n_queries), str(n_atoms), str(n_jobs)]
    child = subprocess.run(command, capture_output=True, text=True, check=False)
    if child.returncode:
        last = (child.stderr.strip().splitlines() or ["no message"])[-1]
        raise OSError(f"the process that predicts {n_queries} queries against {n_atoms} atoms failed: {last}")
    answer: dict[str, Any] = json.loads(child.stdout)
    return answer


def peak_resident_bytes() -> int:
    """Largest resident memory of this process so far.

    Linux hands a child the peak of the process that began it in `ru_maxrss`; `VmHWM` is its own.
    """
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        unit = 1 if sys.platform == "darwin" else 1024
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
    (kib,) = [line.split()[1] for line in status.splitlines() if line.startswith("VmHWM:")]
    return int(kib) * 1024


def main(n_queries: int, n_atoms: int, n_jobs: int) -> None:
    """Predict, then print what it took as JSON."""
    from fusion.sparse_coding import KSC

    rng = np.random.default_rng(0)
    model = KSC(n_jobs=n_jobs).fit(rng.normal(size=(n_atoms, 28)), np.arange(n_atoms) % 27)
    queries = rng.normal(size=(n_queries, 28))
    start = perf_counter()
    labels = model.predict(queries)
    print(json.dumps({"peak_bytes": peak_resident_bytes(), "seconds": perf_counter() - start, "labels": len(labels)}))


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:4]))
