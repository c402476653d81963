"""The grid: one cell for every task, variant, split, feed and method, with the identity that makes its key."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from leaderboard.record import Identity, Role, record_key
from vtbench.run.choose import WEIGHT_CHOICES
from vtbench.run.detection.methods import DETECTORS, DetectorMethod, with_baseline
from vtbench.run.methods import METHODS, Method
from vtbench.run.methods.external import external_method
from vtbench.run.suite import Entry, Suite
from vtbench.tasks import TASKS
from vtbench.tasks.base import Feed, Task
from vtbench.tasks.presses import backbone_identity
from vtbench.tasks.slides import SlipTask

PROTOCOL_VERSION = 1
"""Raised when splitting, choosing or scoring changes for all tasks."""


@dataclass(frozen=True)
class Source:
    """Where a cell's samples come from: a name for people, a content hash, and why there is none, if so."""

    dataset: str
    hash: str
    kind: Literal["simulated", "real"]
    missing: str = ""


@dataclass(frozen=True)
class Cell:
    """One result to be: who is fed what, on which split of which samples."""

    identity: Identity
    key: str
    task: Task
    feed: Feed
    method: Method | DetectorMethod
    timeout_s: float
    backbone: str
    missing: str = ""

    @property
    def group(self) -> tuple[str, str, str, str]:
        """Cells of one group read the same samples through the same backbone."""
        return (self.identity.task, self.identity.variant, self.identity.dataset, self.backbone)


def own_methods(suite: Suite) -> dict[str, Method]:
    """Every method that a suite may name: registered ones and its own.

    Raises:
        ValueError: the module of an own method is not there.
    """
    own = {
        name: external_method(name, spec.estimator, spec.params, spec.choose) for name, spec in suite.methods.items()
    }
    return {**dict(METHODS.items()), **own}


def plan(
    suite: Suite,
    sources: Mapping[tuple[str, str, str | None], Source],
    backbone: Mapping[str, str],
    methods: Mapping[str, Method],
) -> list[Cell]:
    """Cells of a suite, each once, in the order in which they run.

    Args:
        suite: what to run.
        sources: (task, variant, dataset as the entry names it) -> samples.
        backbone: what decides the features of frames, part of the keys of cells that use them, where an entry does
            not name its own.
        methods: by id.
    """
    cells: dict[str, Cell] = {}
    for entry in suite.entries:
        task = TASKS.get(entry.task)
        features = backbone if entry.backbone is None else backbone_identity(entry.backbone)
        for variant, dataset in entry.variants.items():
            source = sources[entry.task, variant, dataset]
            for split, name, role, method in _grid(entry, task, variant, methods):
                feed = task.feed(name)
                identity = Identity(
                    task=task.id,
                    variant=variant,
                    split=split,
                    method=method.id,
                    modality=name,
                    role=role,
                    kind=source.kind,
                    params=_params(task, variant, name, role, feed, method, features),
                    seed=suite.seed,
                    dataset=source.dataset,
                    dataset_hash=source.hash,
                    protocol_version=PROTOCOL_VERSION,
                )
                key = record_key(identity)
                through = entry.backbone or suite.backbone
                cell = Cell(identity, key, task, feed, method, suite.timeout_s, through, source.missing)
                cells.setdefault(key, cell)
    return sorted(cells.values(), key=_neighbours)


def _neighbours(cell: Cell) -> tuple[object, ...]:
    """Cells on the same samples, split and blocks stand together: a worker reduces a block once for all of them."""
    return (*cell.group, cell.identity.split, *(block.name for block in cell.feed.blocks), cell.identity.modality)


def _grid(
    entry: Entry, task: Task, variant: str, methods: Mapping[str, Method]
) -> Iterator[tuple[str, str, Role, Method | DetectorMethod]]:
    """(split, feed, role, method) of one entry on one variant."""
    protocol = task.variants[variant]
    known: Mapping[str, Method | DetectorMethod] = methods
    chosen = entry.methods
    if task.reads == "slides":
        known, chosen = dict(DETECTORS.items()), with_baseline(entry.methods)
    feeds: list[tuple[str, Role, tuple[str, ...]]]
    if protocol.laws:
        feeds = [(name, "law", chosen) for name in protocol.laws]
    else:
        usual = [name for name, feed in task.modalities.items() if not feed.by_name]
        feeds = [(name, "method", chosen) for name in entry.modalities or usual]
        feeds += [(name, "probe", entry.beside(entry.probes)) for name in task.probes]
        feeds += [(name, "upper-line", entry.beside(entry.upper_lines)) for name in task.upper_lines]
    for split in protocol.splits:
        if entry.splits is not None and split not in entry.splits:
            continue
        for name, role, ids in feeds:
            for method in (known[method_id] for method_id in ids):
                feed = task.feed(name)
                if method.takes(feed) if isinstance(method, Method) else len(feed.blocks) > 1 or not method.joint:
                    yield split, name, role, method


def _params(
    task: Task,
    variant: str,
    name: str,
    role: Role,
    feed: Feed,
    method: Method | DetectorMethod,
    backbone: Mapping[str, str],
) -> dict[str, object]:
    """What decides a result beside the names: choices, parameters, backbone."""
    params: dict[str, object] = dict(method.identity())
    if isinstance(task, SlipTask):
        params.update(task.protocol())
    sizes = {block.name: list(block.sizes) for block in feed.blocks if block.sizes}
    if sizes:
        params["sizes"] = sizes
    if len(feed.blocks) > 1:
        chosen = feed.weights == "chosen" and not (isinstance(method, Method) and method.learns)
        params["weights"] = [list(pair) for pair in WEIGHT_CHOICES] if chosen else "equal"
    if any(block.from_frames for block in feed.blocks):
        params.update(backbone)
    stand_ins = task.variants[variant].stand_ins
    read = {block.name: stand_ins[block.name] for block in feed.blocks if block.name in stand_ins}
    if read:
        params["stand_ins"] = {block: [way.train or block, way.test or block] for block, way in read.items()}
    if role == "law":
        params["law"] = task.variants[variant].laws[name]
    return params
