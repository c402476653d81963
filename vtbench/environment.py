"""What a figure depends on outside the code: versions, machine, threads, and where data lie."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import subprocess
from importlib import metadata
from pathlib import Path
from typing import Any

from vtbench.paths import cache_dir, configs_dir

THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "BLIS_NUM_THREADS",
)


def pin_threads() -> None:
    """Give numerical libraries one thread each, where the user chose nothing else.

    Works only before NumPy is imported, and is inherited by child processes.
    """
    for name in THREAD_VARIABLES:
        os.environ.setdefault(name, "1")


def version() -> str:
    """Version of the installed distribution."""
    try:
        return metadata.version("vtbench")
    except metadata.PackageNotFoundError:
        return "unknown"


def packages() -> dict[str, str]:
    """Installed version of every distribution that vtbench requires; those not installed are left out."""
    try:
        required = metadata.requires("vtbench") or []
    except metadata.PackageNotFoundError:
        return {}
    found = {}
    for requirement in required:
        match = re.match(r"[\w.-]+", requirement)
        if match is None or "extra ==" in requirement:
            continue
        try:
            found[match[0]] = metadata.version(match[0])
        except metadata.PackageNotFoundError:
            continue
    return found


def commit() -> str:
    """Commit of the clone that runs, with `-dirty` when files differ from it; empty outside a clone."""
    clone = Path(__file__).resolve().parent.parent
    if not (clone / ".git").exists():
        return ""
    command = ["git", "-C", str(clone), "describe", "--always", "--abbrev=40", "--exclude=*", "--dirty"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, timeout=10, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return answer.stdout.strip() if answer.returncode == 0 else ""


def machine() -> dict[str, Any]:
    """System, processor, cores that this process may use, and memory of the machine in GiB (None: unknown)."""
    return {
        "system": platform.system(),
        "release": platform.release(),
        "architecture": platform.machine(),
        "processor": _processor(),
        "cores": usable_cores(),
        "memory_gib": _memory_gib(),
    }


def fingerprint() -> str:
    """Twelve hex digits that differ between machines whose timings must not be compared."""
    told = {key: value for key, value in machine().items() if key not in ("release", "memory_gib")}
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:12]


def usable_cores() -> int:
    """Cores that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def threads() -> dict[str, str]:
    """The thread limits that numerical libraries read, those that are set."""
    return {name: os.environ[name] for name in THREAD_VARIABLES if name in os.environ}


def recordings() -> dict[str, dict[str, Any]]:
    """Each public set of recordings: its folder (None when it is not on this machine) and what brings it."""
    from vtbench.data.public import PUBLIC, data_root, public_set

    found: dict[str, dict[str, Any]] = {}
    for name in PUBLIC.ids():
        source = public_set(name)
        try:
            folder: str | None = str(data_root(name))
        except ValueError:
            folder = None
        found[name] = {
            "path": folder,
            "title": source.title,
            "licence": source.licence,
            "fetch": f"vtbench fetch {name}",
        }
    return found


def accelerators() -> list[str]:
    """Names of the graphics processors that `--device cuda` can use; loads torch."""
    import torch

    return [torch.cuda.get_device_name(index) for index in range(torch.cuda.device_count())]


def describe() -> dict[str, Any]:
    """Everything that `vtbench env` prints, as JSON-ready values."""
    return {
        "version": version(),
        "commit": commit(),
        "python": platform.python_version(),
        "packages": packages(),
        "machine": machine(),
        "fingerprint": fingerprint(),
        "threads": threads(),
        "cuda": accelerators(),
        "configs": str(configs_dir()),
        "cache": str(cache_dir()),
        "vtbench_data": os.environ.get("VTBENCH_DATA"),
        "recordings": recordings(),
    }


def _processor() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return platform.processor()
    named = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
    return named[1].strip() if named else platform.processor()


def _memory_gib() -> float | None:
    try:
        return round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30, 1)
    except (ValueError, OSError, AttributeError):
        return None
