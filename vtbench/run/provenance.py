"""What the records of a run share about where they come from."""

from __future__ import annotations

import platform
from typing import Any

from vtbench import environment


def provenance() -> dict[str, Any]:
    """Fields of `leaderboard.record.Provenance` but the times."""
    return {
        "version": environment.version(),
        "commit": environment.commit(),
        "python": platform.python_version(),
        "packages": environment.packages(),
        "machine": environment.machine(),
        "fingerprint": environment.fingerprint(),
    }
