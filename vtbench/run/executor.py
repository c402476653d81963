"""Runs cells in processes: one thread each, a time limit, and a dead process costs its own cell only."""

from __future__ import annotations

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
from multiprocessing import get_context
from types import FrameType

from vtbench.run.detection.detect import DetectionWork
from vtbench.run.evaluate import Outcome
from vtbench.run.evaluate import Work as ClassifierWork
from vtbench.tasks.base import NotPossibleError

Work = ClassifierWork | DetectionWork

GRACE = 1.5
"""A process that overran its limit this many times, deaf to the alarm, is ended from outside."""


class OutOfTimeError(Exception):
    """A cell overran its limit."""


def run_all(works: Iterable[Work], jobs: int) -> Iterator[Outcome]:
    """Outcomes as they come, in any order; each work gives exactly one.

    When a worker process dies, what is left runs one cell at a time, each in a process that may die for itself.
    """
    if jobs == 1:
        with _one_thread():
            yield from map(attempt, works)
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


def _one_by_one(works: list[Work]) -> Iterator[Outcome]:
    for work in works:
        started = time.time()
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            try:
                yield pool.submit(_attempt_in_worker, work).result()
            except BrokenProcessPool:
                now = time.time()
                late = now - started > GRACE * work.timeout_s
                yield Outcome(
                    work.key,
                    "timeout" if late else "failed",
                    f"the process died after {now - started:.0f} s (out of memory, or a crash in compiled code)",
                    started=started,
                    finished=now,
                )


@contextmanager
def _one_thread() -> Iterator[None]:
    """Numerical libraries on one thread in this process; only a library that is loaded can be limited."""
    import scipy.linalg  # noqa: F401
    import sklearn.neighbors
    import sklearn.svm  # noqa: F401
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield


@contextmanager
def _limit(seconds: float) -> Iterator[None]:
    """Raise `OutOfTimeError` in the body after `seconds`, where the platform and the thread allow an alarm."""
    if not hasattr(signal, "SIGALRM") or threading.current_thread() is not threading.main_thread():
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


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or "no message"
