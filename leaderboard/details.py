"""All that one record holds, in words: what a reader sees who opens it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from leaderboard.contents import BoardTables
from leaderboard.frame import Row, records_of
from leaderboard.names import METHODS, MODALITIES, SPLITS, title
from leaderboard.ranks import Rank
from leaderboard.record import Metric, Record, canonical_json
from leaderboard.sections import STANDINGS, standing_shown
from leaderboard.slip_cells import delay_text
from leaderboard.views import brief, microseconds, number, span

Facts = list[tuple[str, str]]


@dataclass(frozen=True)
class Detail:
    """One record: what came out, what must be said of it, and every fact it states. `link` is a submission's own."""

    id: str
    title: str
    outcome: str
    ok: bool
    warnings: tuple[str, ...]
    facts: tuple[tuple[str, str], ...]
    metrics: tuple[tuple[str, str, str, str], ...]
    place: int
    standing: str
    link: str


def details_of(records: Sequence[Record], tables: BoardTables, places: Mapping[str, int]) -> dict[str, list[Detail]]:
    """Return the details of all records by task; `places` numbers the environments, by `environment`."""
    judged = {(row["key"], row["fingerprint"]): row for row in records_of(tables.cells)}
    grouped: dict[str, list[Detail]] = {}
    seen: dict[str, int] = {}
    for record in records:
        times = seen[record.key] = seen.get(record.key, 0) + 1
        row = judged[record.key, record.provenance.fingerprint]
        grouped.setdefault(record.identity.task, []).append(_detail(record, row, places[environment(record)], times))
    return grouped


def environment(record: Record) -> str:
    """Return what two records of one environment share, as text."""
    where = record.provenance
    return canonical_json(where.model_dump(mode="json", include={"python", "packages", "machine", "fingerprint"}))


def plain(value: Any) -> str:
    """Return a JSON value as text."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _detail(record: Record, row: Row, place: int, times: int) -> Detail:
    who, given = record.identity, record.submission
    names = (title(METHODS, who.method), title(MODALITIES, row["modality"]), who.variant, title(SPLITS, who.split))
    if given is not None:
        names = (given.title, *names[1:])
    warnings = [row["probe"], row["coverage"] and f"95 % interval: {row['coverage']}"]
    return Detail(
        id=f"r-{record.key[:16]}" + (f"-{times}" if times > 1 else ""),
        title=" · ".join(name for name in names if name),
        outcome=_outcome(record),
        ok=record.status.state == "ok",
        warnings=tuple(text for text in warnings if text),
        facts=tuple(
            [*_law(record), *_submission(record), *_rank(row), *_identity(record), *_cost(record), *_origin(record)]
        ),
        metrics=tuple(_metric(metric) for metric in record.metrics),
        place=place,
        standing=_standing(record),
        link=given.link or "" if given is not None else "",
    )


def _law(record: Record) -> Facts:
    v = record.verdict
    if v is None:
        return []
    return [("law", f"{v.law}: expected {v.expected}, seen {v.observed}, {'holds' if v.passed else 'broken'}")]


def _standing(record: Record) -> str:
    given = record.submission
    return "" if given is None else standing_shown(given.status, record.status.state == "ok")


def _submission(record: Record) -> Facts:
    given, standing = record.submission, _standing(record)
    if given is None:
        return []
    facts = [("submission", f"{given.title} ({given.id})"), ("standing", f"{standing}: {STANDINGS[standing]}")]
    said = {
        "why": given.reason,
        "authors": ", ".join(given.authors),
        "licence": given.licence,
        "trained on": given.trained_on,
        "hardware": given.hardware,
        "claimed": None if given.claimed is None else f"{100 * given.claimed:.1f} %",
        "hidden test set": given.hidden and f"commitment {given.hidden}",
    }
    facts += [(name, str(value)) for name, value in said.items() if value]
    ran = given.artifact
    if ran is not None:
        facts.append(("model file", f"{ran.size_bytes:,} bytes, SHA-256 {ran.sha256}"))
        costs = {
            "parameters": ran.parameters,
            "nodes": ran.nodes,
            "load, s": ran.load_s,
            "peak memory, MB": ran.peak_rss_mb,
        }
        told = [f"{name}: {value:,.6g}" for name, value in costs.items() if value is not None]
        told += [f"batch {t.batch}: {t.p50_ms:.3g} ms (p95 {t.p95_ms:.3g} ms, {t.calls} calls)" for t in ran.latency]
        facts += [("model cost", "\n".join(told))] if told else []
        guards = "\n".join(f"{name}: {held}" for name, held in ran.protections.items())
        facts += [("protections", guards)] if guards else []
    return facts


def _rank(row: Row) -> Facts:
    if row["rank_best"] is None or row["rank_worst"] is None:
        return []
    ranks = Rank(int(row["rank_best"]), int(row["rank_worst"]), row["letters"])
    return [("rank", f"{ranks.text}, tied with those that share a letter of “{ranks.letters}” ({row['ranked']})")]


def _identity(record: Record) -> Facts:
    who = record.identity
    return [
        ("role", who.role),
        ("recordings", who.kind),
        ("dataset", f"{who.dataset}, {who.dataset_hash}"),
        (
            "parameters and choices",
            "\n".join(f"{name}: {plain(value)}" for name, value in who.params.items()) or "none",
        ),
        ("seed", str(who.seed)),
    ]


def _cost(record: Record) -> Facts:
    cost = record.timing
    if cost is None:
        return []
    said = {
        "fit": None if cost.fit_s is None else f"{cost.fit_s:.3g} s",
        "method": cost.predict_us_per_sample and f"{microseconds(cost.predict_us_per_sample)} µs a sample",
        "features": cost.feature_us_per_sample and f"{microseconds(cost.feature_us_per_sample)} µs a sample",
        "peak memory": cost.peak_rss_mb and f"{cost.peak_rss_mb:,.0f} MB",
        "batch": cost.batch and f"batch {cost.batch}",
        "threads": f"{cost.threads} thread{'s' if cost.threads > 1 else ''}",
    }
    shown = [value if name in ("batch", "threads") else f"{name} {value}" for name, value in said.items() if value]
    return [("timing", ", ".join(shown) + (f" ({cost.note})" if cost.note else ""))]


def _origin(record: Record) -> Facts:
    where = record.provenance
    return [
        ("started, finished", f"{where.started:%Y-%m-%d %H:%M:%S %Z}, {where.finished:%H:%M:%S}"),
        ("version", f"{where.version} {where.commit[:12]}".strip()),
        ("key", record.key),
    ]


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
