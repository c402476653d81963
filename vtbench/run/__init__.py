"""The grid of a suite: cells, resume, executor, scores."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vtbench.run.check import check_run as check_run
    from vtbench.run.rescoring import rescore as rescore
    from vtbench.run.runner import run_suite as run_suite
    from vtbench.run.suite import Suite as Suite
    from vtbench.run.summary import RunSummary as RunSummary

_HOMES = {
    "RunSummary": "summary",
    "Suite": "suite",
    "check_run": "check",
    "rescore": "rescoring",
    "run_suite": "runner",
}
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(f"vtbench.run.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
