"""Runs cells in processes: one thread each, a time limit, and a dead process costs its own cell only."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import signal
import threading
import time
import warnings
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from itertools import chain
from multiprocessing import get_all_start_methods, get_context
from multiprocessing.context import BaseContext
from types import FrameType

from vtbench.interruption import raise_interruption
from vtbench.run.detection.detect import DetectionWork
from vtbench.run.evaluate import Outcome
from vtbench.run.evaluate import Work as ClassifierWork
from vtbench.scheduling import Cluster, Died
from vtbench.tasks.base import NotPossibleError

Work = ClassifierWork | DetectionWork

GRACE = 1.5
"""A process that overran its limit this many times, deaf to the alarm, is ended from outside."""


class OutOfTimeError(Exception):
    """A cell overran its limit."""


def run_all(works: Iterable[Work], jobs: int, cluster: Cluster | None = None) -> Iterator[Outcome]:
    """Outcomes as they come, in any order; each work gives exactly one.

    With one job our own methods run in this process and a user's in another. When a worker process dies, what is left
    runs one cell at a time, in a process that may die for itself. A `cluster` runs them elsewhere.
    """
    if cluster is not None:
        yield from _on_cluster(list(works), cluster)
        return
    if jobs == 1:
        yield from _in_order(list(works))
        return
    from joblib import Parallel, delayed, parallel_config
    from joblib.externals.loky.process_executor import BrokenProcessPool as BrokenLoky

    left = {work.key: work for work in works}
    try:
        with parallel_config(backend="loky", inner_max_num_threads=1):
            run = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
            for outcome in run(delayed(_attempt_in_worker)(work) for work in list(left.values())):
                del left[outcome.key]
                yield outcome
    except BrokenLoky:
        yield from _one_by_one(list(left.values()))


def attempt(work: Work) -> Outcome:
    """Evaluate a cell; every way in which it can go wrong becomes an outcome with a one-line reason."""
    _load()
    started = time.time()
    try:
        with warnings.catch_warnings(), _limit(work.timeout_s):
            warnings.simplefilter("ignore")
            outcome = work.evaluate()
    except OutOfTimeError:
        outcome = Outcome(work.key, "timeout", f"took longer than {work.timeout_s:g} s (timeout_s of the suite)")
    except NotPossibleError as error:
        outcome = Outcome(work.key, "skipped", _one_line(error))
    except (Exception, SystemExit) as error:  # a classifier that calls sys.exit must not end the run
        raise_interruption(error)
        outcome = Outcome(work.key, "failed", f"{type(error).__name__}: {_one_line(error)}")
    return replace(outcome, started=started, finished=time.time())


def _attempt_in_worker(work: Work) -> Outcome:
    """As `attempt`; a process that does not hear the alarm (deep in compiled code) ends itself."""
    with open(os.devnull, "w") as nowhere:
        faulthandler.dump_traceback_later(GRACE * work.timeout_s + 1, exit=True, file=nowhere)
        try:
            return attempt(work)
        finally:
            faulthandler.cancel_dump_traceback_later()


def _on_cluster(works: list[Work], cluster: Cluster) -> Iterator[Outcome]:
    started = time.time()
    for place, outcome in cluster.map(_attempt_alone, works):
        if isinstance(outcome, Died):
            outcome = Outcome(works[place].key, "failed", outcome.reason, started=started, finished=time.time())
        yield outcome


def _attempt_alone(work: Work) -> Outcome:
    with _one_thread():
        return _attempt_in_worker(work)


def _in_order(works: list[Work]) -> Iterator[Outcome]:
    ours = [work for work in works if not _foreign(work)]
    with _one_thread():
        yield from map(attempt, ours)
    yield from _one_by_one([work for work in works if _foreign(work)])


def _foreign(work: Work) -> bool:
    """A user's classifier: it may end the process that it runs in."""
    return isinstance(work, ClassifierWork) and "estimator" in work.method.source


def _one_by_one(works: list[Work]) -> Iterator[Outcome]:
    """One cell at a time, in a process that is replaced when it dies."""
    left = iter(works)
    for work in left:
        with ProcessPoolExecutor(1, mp_context=_context(), initializer=_load) as pool:
            for current in chain([work], left):
                started = time.time()
                try:
                    yield pool.submit(_attempt_in_worker, current).result()
                except BrokenProcessPool:
                    yield _died(current, started)
                    break


def _context() -> BaseContext:
    """Fresh processes that have the numerical libraries already, where the platform can fork them."""
    if "forkserver" not in get_all_start_methods():
        return get_context("spawn")
    context = get_context("forkserver")
    context.set_forkserver_preload([__name__, "sklearn.neighbors", "sklearn.svm", "fusion.sparse_coding"])
    return context


def _died(work: Work, started: float) -> Outcome:
    now = time.time()
    late = now - started > GRACE * work.timeout_s
    reason = f"the process died after {now - started:.0f} s (out of memory, or a crash in compiled code)"
    return Outcome(work.key, "timeout" if late else "failed", reason, started=started, finished=now)


def _load() -> None:
    """Import what every cell needs before a time limit runs: an alarm inside an import leaves half a module behind."""
    import scipy.linalg  # noqa: F401
    import sklearn.neighbors
    import sklearn.svm  # noqa: F401

    import fusion.sparse_coding  # noqa: F401


@contextmanager
def _one_thread() -> Iterator[None]:
    """Numerical libraries on one thread in this process; only a library that is loaded can be limited."""
    from threadpoolctl import threadpool_limits

    _load()
    with threadpool_limits(1):
        yield


@contextmanager
def _limit(seconds: float) -> Iterator[None]:
    """Raise `OutOfTimeError` in the body after `seconds`, by an alarm where the platform and the thread allow one."""
    if not hasattr(signal, "SIGALRM") or threading.current_thread() is not threading.main_thread():
        with _limit_of_thread(seconds):
            yield
        return

    def ring(number: int, frame: FrameType | None) -> None:
        raise OutOfTimeError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@contextmanager
def _limit_of_thread(seconds: float) -> Iterator[None]:
    """As `_limit`, in a thread that hears no alarm: the interpreter raises the error in it."""
    thread, lock, done = threading.get_ident(), threading.Lock(), False

    def ring() -> None:
        with lock:
            if not done:
                ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(OutOfTimeError))

    timer = threading.Timer(seconds, ring)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        with lock:
            done = True
        timer.cancel()


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or "no message"
