"""Tables and records -> one HTML page that needs nothing from outside and escapes whatever a record says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime

from jinja2 import Environment, PackageLoader, StrictUndefined

from leaderboard.contents import BoardTables, TaskGroup
from leaderboard.details import details_of, environment, plain
from leaderboard.paper import CITATION
from leaderboard.plots import Figure, pose_figure, speed_figure
from leaderboard.record import Record
from leaderboard.sections import beside_views, laws_view, pose_view, probe_views, result_view
from leaderboard.slip_plot import delay_figure
from leaderboard.slip_tables import SlipBlock
from leaderboard.slip_views import split_views, table_iv
from leaderboard.studies import study_views
from leaderboard.study_plots import study_figure
from leaderboard.tables import ResultTable
from leaderboard.views import View


@dataclass(frozen=True)
class Part:
    """A table with the plot that belongs to it; `folded` where the plot says it all and the table is there to check."""

    view: View
    figure: Figure | None
    folded: bool = False


@dataclass(frozen=True)
class Section:
    """One task: its curve, if it has one, and its tables."""

    id: str
    task: str
    kind: str
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Place:
    """An environment in which records were made."""

    number: int
    machine: str
    facts: tuple[tuple[str, str], ...]
    packages: tuple[tuple[str, str], ...]
    count: int


def render_page(records: Sequence[Record], tables: BoardTables, title: str, generated: datetime) -> str:
    """Return the page. Every string is escaped by the template; the page carries a policy that forbids requests."""
    env = Environment(
        loader=PackageLoader("leaderboard"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    states = [record.status.state for record in records]
    places = _places(records, tables)
    return env.get_template("board.html.j2").render(
        title=title,
        generated=generated,
        notices=tables.notices,
        papers=[_part(table, tables, f"paper-{i}") for i, table in enumerate(tables.papers)]
        + [Part(view, None) for block in tables.slips if (view := table_iv(block)) is not None],
        citation=CITATION,
        sections=_sections(tables),
        beside=beside_views(tables.beside),
        probes=probe_views(tables.probes),
        laws=laws_view(tables.laws) if len(tables.laws) else None,
        details=details_of(records, tables, {name: place.number for name, place in places.items()}),
        places=list(places.values()),
        counts={"ok": states.count("ok"), "other": len(states) - states.count("ok"), "all": len(states)},
        kinds=sorted({record.identity.kind for record in records}),
        versions=sorted({record.provenance.version for record in records}),
        commits=sorted({record.provenance.commit[:12] for record in records if record.provenance.commit}),
        started=min((r.provenance.started for r in records), default=None),
        finished=max((r.provenance.finished for r in records), default=None),
    )


def _part(table: ResultTable, tables: BoardTables, name: str) -> Part:
    speed = tables.speed
    for field in ("task", "protocol_version", "variant", "kind", "dataset", "dataset_hash"):
        speed = speed[speed[field] == getattr(table, field)]
    return Part(result_view(table, tables.machines), speed_figure(speed, name, tables.better))


def _sections(tables: BoardTables) -> list[Section]:
    return [
        Section(f"task-{at}", group.task, group.kind, tuple(_group_parts(group, tables, f"task-{at}")))
        for at, group in enumerate(tables.groups)
    ]


def _group_parts(group: TaskGroup, tables: BoardTables, name: str) -> Iterator[Part]:
    if len(group.curve):
        yield Part(pose_view(group.curve), pose_figure(group.curve, name), folded=True)
    views = study_views(group.study)
    for at, view in enumerate(views):  # one figure stands for all of them
        yield Part(view, study_figure(group.study, name) if at == 0 else None, folded=True)
    for at, table in enumerate(group.tables):
        part = _part(table, tables, f"{name}-{at}")
        # a detector's cost stands against its delay, not against its misses
        yield Part(part.view, None) if group.task.startswith("slip/") else part
    for at, block in enumerate(block for block in tables.slips if block.task == group.task):
        yield from _slip_parts(block, f"{name}-slip-{at}")


def _slip_parts(block: SlipBlock, name: str) -> Iterator[Part]:
    for split in block.splits:
        for at, view in enumerate(split_views(block, split)):
            yield Part(view, delay_figure(block, split, f"{name}-{split}") if at == 0 else None)


def _places(records: Sequence[Record], tables: BoardTables) -> dict[str, Place]:
    places: dict[str, Place] = {}
    counts: dict[str, int] = {}
    for record in records:
        name = environment(record)
        counts[name] = counts.get(name, 0) + 1
    for record in records:
        name, where = environment(record), record.provenance
        if name not in places:
            facts = [("fingerprint", where.fingerprint), ("Python", where.python)]
            facts += [(key.replace("_", " "), plain(value)) for key, value in where.machine.items()]
            machine = tables.machines[where.fingerprint]
            packages = tuple(sorted(where.packages.items()))
            places[name] = Place(len(places) + 1, machine, tuple(facts), packages, counts[name])
    return places
