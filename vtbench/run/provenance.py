"""Where a record comes from: versions, commit, machine."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import subprocess
from importlib import metadata
from pathlib import Path
from typing import Any

import vtbench

_PACKAGES = ("numpy", "scipy", "scikit-learn", "onnxruntime", "pandas", "pyarrow", "joblib")


def provenance() -> dict[str, Any]:
    """Fields of `leaderboard.record.Provenance` that all records of a run share."""
    machine = {"system": platform.system(), "arch": platform.machine(), "cpu": _cpu(), "cores": os.cpu_count()}
    digest = hashlib.sha256(json.dumps(machine, sort_keys=True).encode()).hexdigest()
    return {
        "version": metadata.version("vtbench"),
        "commit": _commit(),
        "python": platform.python_version(),
        "packages": {name: metadata.version(name) for name in _PACKAGES},
        "machine": machine,
        "fingerprint": digest[:16],
    }


def _cpu() -> str:
    """Model name of the processor."""
    info = Path("/proc/cpuinfo")
    if info.is_file():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor()


def _commit() -> str:
    """Commit of the clone that this package runs from; empty when it is installed elsewhere."""
    folder = Path(vtbench.__file__).resolve().parent.parent
    if not (folder / ".git").exists():
        return ""
    try:
        done = subprocess.run(
            ["git", "-C", str(folder), "rev-parse", "HEAD"], capture_output=True, text=True, timeout=5, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.strip()
