"""The cells of a run's folder."""

from __future__ import annotations

from pathlib import Path

from vtbench.run.cells import Cell, own_methods, plan
from vtbench.run.sources import find_sources
from vtbench.run.suite import Suite


def planned(suite: Suite, out: Path) -> list[Cell]:
    """Cells of a suite whose datasets lie in `out`.

    Raises:
        ValueError: a dataset that is not there.
    """
    from vtbench.tasks.presses import backbone_identity

    return plan(suite, find_sources(suite, out), backbone_identity(suite.backbone), own_methods(suite))
