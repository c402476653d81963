"""Work on a Dask cluster: `--scheduler tcp://HOST:PORT`, workers of the same vtbench, nothing lost when one dies.

The scheduler gives the work of a dead worker to another. Results are the same bytes as those of processes on this
machine, which is why workers must run the same code and one thread each.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Generic, TypeVar

T = TypeVar("T")
R = TypeVar("R")

CONNECT_S = 10
PATIENCE_S = 60
"""How long a cluster may be without any worker before the work is given up."""
_POLL_S = 5
_ADDRESS = re.compile(r"(tcp|tls)://(\[[0-9a-fA-F:]+\]|[^\s:/\[\]]+):\d{1,5}")
_PACKAGES = ("vtbench", "sensors", "fusion", "slip", "leaderboard")


@dataclass(frozen=True)
class Died:
    """In place of a result: the workers that tried died, and the scheduler tries no more.

    Attributes:
        reason: one line.
    """

    reason: str


@contextlib.contextmanager
def connect(address: str | None) -> Iterator[Cluster | None]:
    """Yield the cluster whose scheduler is at `address`, checked and ready; None without an address.

    Raises:
        ValueError: a malformed address, Dask is not installed, or a worker of another version or with more threads
            than one.
        OSError: nobody answers there, or it has no workers.
    """
    if address is None:
        yield None
        return
    if not _ADDRESS.fullmatch(address):
        raise ValueError(f"--scheduler: expected an address such as tcp://127.0.0.1:8786, got {address!r}")
    try:
        import dask
        from distributed import Client
    except ImportError as error:
        raise ValueError(f"the option --scheduler needs Dask ({error}): pip install 'vtbench[cluster]'") from None
    quiet = {
        "distributed.comm.timeouts.connect": f"{CONNECT_S}s",
        "distributed.admin.large-graph-warning-threshold": "1TB",
    }
    for name in list(logging.root.manager.loggerDict):
        if name.startswith("distributed"):  # what goes wrong is said in one line of ours
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(quiet))
        try:
            client = stack.enter_context(Client(address, timeout=CONNECT_S))
        except (OSError, TimeoutError, ValueError) as error:
            raise OSError(
                f"{address}: no Dask scheduler answers there ({_one_line(error)}); start one: dask scheduler"
            ) from None
        cluster = Cluster(client, address)
        cluster.check()
        yield cluster


class Cluster:
    """Workers behind one scheduler."""

    def __init__(self, client: Any, address: str) -> None:
        self._client = client
        self.address = address

    def check(self) -> None:
        """Refuse a cluster whose workers would not give the same bytes; errors of `connect`."""
        try:
            self._client.wait_for_workers(1, timeout=CONNECT_S)
        except TimeoutError:
            raise OSError(
                f"{self.address}: the scheduler has no workers; start some: dask worker {self.address} --nthreads 1"
            ) from None
        threads = self._client.nthreads()
        if wide := {worker: count for worker, count in threads.items() if count != 1}:
            worker, count = next(iter(wide.items()))
            raise ValueError(f"{worker}: a worker with {count} threads; start workers with --nthreads 1")
        here = code_identity()
        try:
            there = self._client.run(code_identity)
        except Exception as error:
            raise ValueError(
                f"{self.address}: a worker cannot run vtbench ({_one_line(error)}); install vtbench "
                f"{here['vtbench']} there"
            ) from None
        for worker, identity in there.items():
            if difference := _difference(here, identity):
                raise ValueError(f"{worker}: {difference}; install the same there and start the worker again")

    def shares(self, folder: Path) -> None:
        """Refuse a cluster whose workers do not see `folder`; ValueError names the worker."""
        for worker, sees in self._client.run(os.path.isdir, str(folder.resolve())).items():
            if not sees:
                raise ValueError(
                    f"{worker}: sees no folder {folder.resolve()}; workers of a run need the file system of the run"
                )

    def map(self, function: Callable[[T], R], items: Sequence[T]) -> Iterator[tuple[int, R | Died]]:
        """(place in `items`, result) of each, as they come; an exception of `function` is raised.

        Args:
            function: depends on nothing but its argument; picklable.
            items: picklable; a few for each worker are under way at a time.

        Raises:
            OSError: the scheduler went away, or there was no worker for `PATIENCE_S` seconds.
        """
        task = _Task(function, code_identity(), os.getcwd(), tuple(sys.path))
        left = iter(enumerate(items))
        running: dict[Any, int] = {}
        try:
            while True:
                for _ in range(2 * max(1, len(self._client.nthreads())) - len(running)):
                    if (following := next(left, None)) is None:
                        break
                    running[self._client.submit(task, following[1], pure=False)] = following[0]
                if not running:
                    return
                for future in self._some(list(running)):
                    yield running.pop(future), self._result(future)
        except OSError:
            raise
        except Exception as error:
            if type(error).__module__.startswith(("distributed", "dask", "concurrent", "asyncio", "tornado")):
                raise OSError(
                    f"{self.address}: the scheduler went away ({type(error).__name__}); what is finished is kept: run "
                    "the same command again"
                ) from None
            raise
        finally:
            with contextlib.suppress(Exception):
                self._client.cancel(list(running))

    def in_order(self, function: Callable[[T], R], items: Sequence[T]) -> Iterator[R]:
        """As `map`, in the order of `items`; OSError where the workers that tried one died."""
        early: dict[int, R] = {}
        following = 0
        for place, result in self.map(function, items):
            if isinstance(result, Died):
                raise OSError(f"{self.address}: {result.reason}")
            early[place] = result
            while following in early:
                yield early.pop(following)
                following += 1

    def _some(self, futures: list[Any]) -> list[Any]:
        """Futures that are done, at least one."""
        from distributed import wait

        alone = 0
        while True:
            try:
                return list(wait(futures, timeout=_POLL_S, return_when="FIRST_COMPLETED").done)
            except TimeoutError:
                alone = 0 if self._client.nthreads() else alone + _POLL_S
            if alone >= PATIENCE_S:
                raise OSError(
                    f"{self.address}: no worker is left; what is finished is kept: run the same command again"
                )

    def _result(self, future: Any) -> Any:
        from distributed import KilledWorker

        try:
            return future.result()
        except KilledWorker:
            return Died("each worker that tried it died (killed, out of memory, or a crash in compiled code)")


@dataclass(frozen=True)
class _Task(Generic[T, R]):
    """A function as a worker runs it: the caller's code, folder and import path."""

    function: Callable[[T], R]
    identity: dict[str, str]
    folder: str
    path: tuple[str, ...]

    def __call__(self, item: T) -> R:
        if difference := _difference(self.identity, code_identity()):
            raise ValueError(f"a worker that joined later has other code: {difference}")
        sys.path.extend(place for place in self.path if place not in sys.path)
        with contextlib.chdir(self.folder) if os.path.isdir(self.folder) else contextlib.nullcontext():
            return self.function(item)


@cache
def code_identity() -> dict[str, str]:
    """What decides results: versions of Python, vtbench and its numerical libraries, and a digest of the source."""
    import hashlib

    from vtbench.data.writer import generator

    digest = hashlib.sha256()
    root = Path(__file__).resolve().parents[1]
    for package in _PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    python = ".".join(map(str, sys.version_info[:2]))
    return {**generator(), "python": python, "source of vtbench": digest.hexdigest()[:12]}


def _difference(here: dict[str, str], there: dict[str, str]) -> str | None:
    for name, version in here.items():
        if there.get(name) != version:
            return f"{name} is {there.get(name)} there, {version} here"
    return None


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
