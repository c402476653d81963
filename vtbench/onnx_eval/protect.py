"""Locks that a process puts on itself before it touches somebody else's file; each says whether it held.

Linux: no new privileges, a network of its own without any device, nothing written and then nothing opened (Landlock),
limits on memory, processor time and files. Elsewhere only the limits. A lock that the kernel refuses is named in the
record, it does not stop the evaluation.
"""

from __future__ import annotations

import ctypes
import errno
import os
import socket
import sys
from collections.abc import Callable
from typing import Any

HELD = "held"
_NEW_USER, _NEW_NET, _NEW_IPC = 0x10000000, 0x40000000, 0x08000000
_NO_NEW_PRIVS, _DUMPABLE = 38, 4
_CREATE_RULESET, _RESTRICT_SELF = 444, 446
_FILE_RIGHTS = {1: 13, 2: 14, 3: 15, 4: 15}
"""Number of file rights by Landlock version; 16 since the fifth."""
_SHUTS_TCP = 4
"""First Landlock version that does."""
_READING = 0b1101
"""Rights to execute, to read a file and to read a folder; without the first nothing could be imported."""
_OPEN_FILES = 32
_CPU_GRACE_S = 5


class _Ruleset(ctypes.Structure):
    _fields_ = (("files", ctypes.c_uint64), ("net", ctypes.c_uint64), ("scoped", ctypes.c_uint64))


def isolate() -> dict[str, str]:
    """Give up privileges, the network and writing; while there is one thread, so that it holds for all to come."""
    if sys.platform != "linux":
        return dict.fromkeys(("privileges", "network", "writing"), f"not held: {sys.platform} has no such lock here")
    kernel = ctypes.CDLL(None, use_errno=True)
    privileges = kernel.prctl(_NO_NEW_PRIVS, 1, 0, 0, 0)
    kernel.prctl(_DUMPABLE, 0, 0, 0, 0)
    found = {"privileges": HELD if privileges == 0 else _refused()}
    separated = kernel.unshare(_NEW_USER | _NEW_NET | _NEW_IPC) == 0
    found["network"] = (HELD if _no_way_out() else "not held: a route is left") if separated else _refused()
    found["writing"] = _shut(kernel, lambda every: every & ~_READING)
    if found["network"] != HELD and found["writing"] == HELD and _version(kernel) >= _SHUTS_TCP:
        found["network"] += "; TCP connections are shut"
    return found


def limit(memory_mb: int, time_s: float) -> dict[str, str]:
    """Limit memory to `memory_mb` beyond what is mapped now, processor time, written files (none), open ones, cores."""
    try:
        import resource
    except ImportError:
        return dict.fromkeys(("memory", "processor time", "file size"), "not held: no such limits on this system")
    mapped = _mapped_bytes()
    cpu = int(time_s) + _CPU_GRACE_S
    limits = {
        "memory": (resource.RLIMIT_AS, mapped + memory_mb * 2**20),
        "processor time": (resource.RLIMIT_CPU, cpu),
        "file size": (resource.RLIMIT_FSIZE, 0),
    }
    found = {name: _set(resource, which, value) for name, (which, value) in limits.items()}
    for which, value in ((resource.RLIMIT_NOFILE, _OPEN_FILES), (resource.RLIMIT_CORE, 0)):
        _set(resource, which, value)
    return found


def close_files() -> dict[str, str]:
    """Let this thread open no file any more; a thread that the runtime began on import still may, for reading."""
    if sys.platform != "linux":
        return {"reading": f"not held: {sys.platform} has no such lock here"}
    kernel = ctypes.CDLL(None, use_errno=True)
    held = _shut(kernel, lambda every: every)
    return {"reading": held if held != HELD or _nothing_opens() else "not held: a file could still be opened"}


def _shut(kernel: Any, chosen: Callable[[int], int]) -> str:
    """Give up those file rights that `chosen` keeps of all that this kernel knows, TCP, and signals to others."""
    version = _version(kernel)
    if version < 1:
        return _refused()
    every = (1 << _FILE_RIGHTS.get(version, 16)) - 1
    rules = _Ruleset(chosen(every), 3 if version >= _SHUTS_TCP else 0, 3 if version >= 6 else 0)
    size = 8 if version < _SHUTS_TCP else 16 if version < 6 else 24
    handle = kernel.syscall(_CREATE_RULESET, ctypes.byref(rules), ctypes.c_size_t(size), ctypes.c_uint32(0))
    if handle < 0:
        return _refused()
    done = kernel.syscall(_RESTRICT_SELF, ctypes.c_int(handle), ctypes.c_uint32(0))
    refused = _refused()
    os.close(handle)
    return HELD if done == 0 else refused


def _version(kernel: Any) -> int:
    """Version of Landlock in this kernel, below 1 without."""
    return int(kernel.syscall(_CREATE_RULESET, None, ctypes.c_size_t(0), ctypes.c_uint32(1)))


def _set(resource: Any, which: int, value: int) -> str:
    try:
        hard = resource.getrlimit(which)[1]
        value = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(which, (value, value))
    except (ValueError, OSError) as error:
        return f"not held: {error}"
    return HELD


def _mapped_bytes() -> int:
    try:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 2**30


def _no_way_out() -> bool:
    """Whether a datagram to an address for documentation has no route."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        try:
            end.connect(("192.0.2.1", 9))
        except OSError:
            return True
    return False


def _nothing_opens() -> bool:
    try:
        os.close(os.open(sys.executable, os.O_RDONLY))
    except OSError as error:
        return error.errno == errno.EACCES
    return False


def _refused() -> str:
    number = ctypes.get_errno()
    return f"not held: the kernel refused ({errno.errorcode.get(number, str(number))})"
