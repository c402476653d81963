"""What is timed: the network that makes features of frames, a fitted classifier, a detector."""

from __future__ import annotations

from collections.abc import Iterable, Set
from dataclasses import dataclass, replace
from typing import Literal

from vtbench.run.cells import Cell
from vtbench.run.methods import Method

Kind = Literal["features", "classifier", "detector"]
FRAME_BLOCKS = ("image", "image-change")


@dataclass(frozen=True)
class Subject:
    """One thing to time.

    Attributes:
        name: as tables print it, `objects/deep/v1 force svm`.
        key: of the cell it is taken from; the first of those that share it.
        block: of the frames, where it is a network.
        copy: `a`, or `b` for the control, the same thing timed again as if it were another.
    """

    name: str
    kind: Kind
    key: str
    block: str = ""
    copy: str = "a"

    @property
    def slug(self) -> str:
        """Name of its folder."""
        return "-".join(filter(None, (self.kind, self.block, self.key[:16], self.copy)))


def subjects_of(cells: Iterable[Cell], done: Set[str], only: str = "") -> list[Subject]:
    """Methods of a run, each once a task and feed, the networks before them, and the control last.

    Args:
        cells: planned cells of the suite.
        done: keys of cells that have predictions.
        only: text that a name must hold.
    """
    found: dict[str, Subject] = {}
    for cell in cells:
        identity = cell.identity
        if cell.key not in done or identity.role != "method":
            continue
        for block in cell.feed.blocks:
            if block.name in FRAME_BLOCKS:
                name = f"{cell.backbone}, {block.name}"
                found.setdefault(f"features {name}", Subject(name, "features", cell.key, block.name))
        kind: Kind = "classifier" if isinstance(cell.method, Method) else "detector"
        name = f"{identity.task} {identity.modality} {identity.method}"
        found.setdefault(name, Subject(name, kind, cell.key))
    wanted = [subject for subject in found.values() if only in subject.name]
    ordered = sorted(wanted, key=lambda subject: subject.kind != "features")
    control = next((subject for subject in ordered if subject.kind != "features"), None)
    return ordered if control is None else [*ordered, replace(control, copy="b")]
