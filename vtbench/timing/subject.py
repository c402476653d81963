"""What is timed: the network that makes features of frames, a fitted classifier, a detector."""

from __future__ import annotations

from collections.abc import Iterable, Set
from dataclasses import dataclass, replace
from typing import Literal

from leaderboard.names import SPLITS, VARIANTS, fed_with, order
from vtbench.run.cells import Cell
from vtbench.run.methods import Method

Kind = Literal["features", "classifier", "detector"]
FRAME_BLOCKS = ("image", "image-change")


@dataclass(frozen=True)
class Subject:
    """One thing to time.

    Attributes:
        name: as tables print it, `objects/deep/v1 force svm`.
        key: of the cell it is taken from.
        block: of the frames, where it is a network.
        copy: `a`, or `b` for the control, the same thing timed again as if it were another.
        row: keys of all cells that take its figures, one a split: a table shows one speed a row.
        features: slugs of the networks that feed it.
    """

    name: str
    kind: Kind
    key: str
    block: str = ""
    copy: str = "a"
    row: tuple[str, ...] = ()
    features: tuple[str, ...] = ()

    @property
    def slug(self) -> str:
        """Name of its folder."""
        return "-".join(filter(None, (self.kind, self.block, self.key[:16], self.copy)))


def subjects_of(cells: Iterable[Cell], done: Set[str], only: str = "") -> list[Subject]:
    """Methods of a run, each once a task and feed, the networks before them, and the control last.

    A method is timed on the first protocol and split that the tables show of it; that row takes the figures.

    Args:
        cells: planned cells of the suite.
        done: keys of cells that have predictions.
        only: text that a name must hold.
    """
    rows: dict[str, list[Cell]] = {}
    for cell in sorted(cells, key=_shown):
        who = cell.identity
        if cell.key in done and who.role == "method":
            rows.setdefault(f"{who.task} {fed_with(who.modality, who.params)} {who.method}", []).append(cell)
    networks: dict[str, Subject] = {}
    methods = []
    for name, (first, *others) in rows.items():
        fed = []
        for block in first.feed.blocks:
            if block.name in FRAME_BLOCKS:
                network = f"{first.backbone}, {block.name}"
                fed.append(networks.setdefault(network, Subject(network, "features", first.key, block.name)).slug)
        kind: Kind = "classifier" if isinstance(first.method, Method) else "detector"
        row = (first.key, *(cell.key for cell in others if _table(cell) == _table(first)))
        methods.append(Subject(name, kind, first.key, row=row, features=tuple(fed)))
    ordered = [subject for subject in (*networks.values(), *methods) if only in subject.name]
    control = next((subject for subject in ordered if subject.kind != "features"), None)
    return ordered if control is None else [*ordered, replace(control, copy="b")]


def _shown(cell: Cell) -> tuple[object, ...]:
    """Order of the tables."""
    who = cell.identity
    return (order(VARIANTS, who.variant), order(SPLITS, who.split))


def _table(cell: Cell) -> tuple[str, str]:
    return (cell.identity.variant, cell.identity.dataset_hash)
