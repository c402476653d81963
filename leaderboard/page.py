"""Tables and records -> one HTML page that needs nothing from outside and escapes whatever a record says."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from leaderboard.contents import BoardTables, TaskGroup
from leaderboard.names import METHODS, MODALITIES, SPLITS, title
from leaderboard.paper import CITATION
from leaderboard.plots import Figure, pose_figure, speed_figure
from leaderboard.record import Metric, Record, canonical_json
from leaderboard.sections import laws_view, pose_view, probe_views, result_view
from leaderboard.slip_cells import delay_text
from leaderboard.slip_plot import delay_figure
from leaderboard.slip_tables import SlipBlock
from leaderboard.slip_views import split_views, table_iv
from leaderboard.tables import ResultTable
from leaderboard.views import View, brief, microseconds, number, span


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
class Detail:
    """All that one record holds, in words."""

    id: str
    title: str
    outcome: str
    ok: bool
    facts: tuple[tuple[str, str], ...]
    metrics: tuple[tuple[str, str, str, str], ...]
    place: int


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
        probes=probe_views(tables.probes),
        laws=laws_view(tables.laws) if len(tables.laws) else None,
        details=_details(records, places),
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
    return Part(result_view(table, tables.machines), speed_figure(speed, name))


def _sections(tables: BoardTables) -> list[Section]:
    return [
        Section(f"task-{at}", group.task, group.kind, tuple(_group_parts(group, tables, f"task-{at}")))
        for at, group in enumerate(tables.groups)
    ]


def _group_parts(group: TaskGroup, tables: BoardTables, name: str) -> Iterator[Part]:
    if len(group.curve):
        yield Part(pose_view(group.curve), pose_figure(group.curve, name), folded=True)
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


def _details(records: Sequence[Record], places: dict[str, Place]) -> dict[str, list[Detail]]:
    """Return the details of all records by task, in the order of the table of records."""
    grouped: dict[str, list[Detail]] = {}
    seen: dict[str, int] = {}
    for record in records:
        times = seen[record.key] = seen.get(record.key, 0) + 1
        detail = _detail(record, places[_environment(record)].number, times)
        grouped.setdefault(record.identity.task, []).append(detail)
    return grouped


def _detail(record: Record, place: int, times: int) -> Detail:
    who, where, cost = record.identity, record.provenance, record.timing
    facts = [
        ("role", who.role),
        ("recordings", who.kind),
        ("dataset", f"{who.dataset}, {who.dataset_hash}"),
        ("parameters", "\n".join(f"{name}: {_plain(value)}" for name, value in who.params.items()) or "none"),
        ("seed", str(who.seed)),
        ("started, finished", f"{where.started:%Y-%m-%d %H:%M:%S %Z}, {where.finished:%H:%M:%S}"),
        ("version", f"{where.version} {where.commit[:12]}".strip()),
        ("key", record.key),
    ]
    if cost is not None:
        said = {
            "fit": None if cost.fit_s is None else f"{cost.fit_s:.3g} s",
            "method": cost.predict_us_per_sample and f"{microseconds(cost.predict_us_per_sample)} µs a sample",
            "features": cost.feature_us_per_sample and f"{microseconds(cost.feature_us_per_sample)} µs a sample",
            "batch": cost.batch and f"batch {cost.batch}",
            "threads": f"{cost.threads} thread{'s' if cost.threads > 1 else ''}",
        }
        shown = [value if name in ("batch", "threads") else f"{name} {value}" for name, value in said.items() if value]
        facts.insert(5, ("timing", ", ".join(shown) + (f" ({cost.note})" if cost.note else "")))
    if record.verdict is not None:
        v = record.verdict
        facts.insert(
            0, ("law", f"{v.law}: expected {v.expected}, seen {v.observed}, {'holds' if v.passed else 'broken'}")
        )
    names = (title(METHODS, who.method), title(MODALITIES, who.modality), who.variant, title(SPLITS, who.split))
    return Detail(
        id=f"r-{record.key[:16]}" + (f"-{times}" if times > 1 else ""),
        title=" · ".join(name for name in names if name),
        outcome=_outcome(record),
        ok=record.status.state == "ok",
        facts=tuple(facts),
        metrics=tuple(_metric(metric) for metric in record.metrics),
        place=place,
    )


def _outcome(record: Record) -> str:
    if record.status.state != "ok":
        return f"{record.status.state}: {brief(record.status.reason)}"
    if not record.metrics:
        return "ok"
    name, value, interval, _ = _metric(record.metrics[0])
    return f"{name} {value}" + (f" ({interval})" if interval else "")


def _metric(metric: Metric) -> tuple[str, str, str, str]:
    if metric.unit == "ms" and metric.low is not None and metric.high is not None:
        ends = f"{delay_text(metric.low)} to {delay_text(metric.high)}"
        return metric.name, f"{delay_text(metric.value)} ms", ends, f"{metric.n} trials, {metric.interval}"
    scale, digits, unit = (100, 1, " %") if metric.unit == "fraction" else (1, 3, f" {metric.unit}")
    low, high = (None if end is None else scale * end for end in (metric.low, metric.high))
    how = f"{metric.n} predictions, {metric.groups} groups" + (f", {metric.interval}" if metric.interval else "")
    return metric.name, number(scale * metric.value, digits) + unit, span(low, high, digits), how


def _environment(record: Record) -> str:
    where = record.provenance
    return canonical_json(where.model_dump(mode="json", include={"python", "packages", "machine", "fingerprint"}))


def _places(records: Sequence[Record], tables: BoardTables) -> dict[str, Place]:
    places: dict[str, Place] = {}
    counts: dict[str, int] = {}
    for record in records:
        name = _environment(record)
        counts[name] = counts.get(name, 0) + 1
    for record in records:
        name, where = _environment(record), record.provenance
        if name not in places:
            facts = [("fingerprint", where.fingerprint), ("Python", where.python)]
            facts += [(key.replace("_", " "), _plain(value)) for key, value in where.machine.items()]
            machine = tables.machines[where.fingerprint]
            packages = tuple(sorted(where.packages.items()))
            places[name] = Place(len(places) + 1, machine, tuple(facts), packages, counts[name])
    return places


def _plain(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
