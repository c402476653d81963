"""Method against method: which records face each other, and what may be said of their scores and of their cost."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import hypot

from scipy.special import ndtr, ndtri

from leaderboard.caution import coverage_warning
from leaderboard.names import fed_with
from leaderboard.paired import MARGIN, Comparison, Verdict, compare_groups, verdicts
from leaderboard.record import Record
from leaderboard.statistics import Interval
from leaderboard.tally import Tallies

UNPAIRED = "difference of two intervals, not paired"

Pair = tuple[Record, Record]


@dataclass(frozen=True)
class Versus:
    """One pair on the same task, variant, split and data. `verdict` is Holm-adjusted over the pairs of a protocol.

    `coverage` says why the interval may not cover 95 %, `probes` which of the two scores a probe comes near.

    `cost_ratio` is first over second in time a sample, features included; None, with `cost_note`, where it cannot be.
    """

    first: Record
    second: Record
    comparison: Comparison
    verdict: Verdict
    paired: bool
    coverage: str
    probes: tuple[str, ...]
    cost_ratio: float | None
    cost_note: str


def name_of(record: Record) -> str:
    """Return `method@modality`, as `vtbench compare --methods` takes it."""
    return f"{record.identity.method}@{fed_with(record.identity.modality, record.identity.params)}"


def within(records: Iterable[Record], names: Sequence[str] = ()) -> list[Pair]:
    """Return all pairs of each protocol of one run, or those of the methods named; the better score first.

    A name is `method@modality` or the first hex digits of a record's key. ValueError for a name that is not there.
    """
    kept = usable(records)
    _known(names, kept)
    pairs: list[Pair] = []
    for rows in _protocols(kept).values():
        found = [r for r in rows if not names or any(_named(r, name) for name in names)]
        pairs += combinations(sorted(found, key=_goodness, reverse=True), 2)
    return pairs


def with_best(rows: Iterable[Versus]) -> list[Versus]:
    """Return of all pairs of each protocol those of its best method; verdicts stay adjusted over all pairs."""
    best: dict[tuple[str, ...], str] = {}
    return [row for row in rows if best.setdefault(protocol_of(row.first), row.first.key) == row.first.key]


def between(first: Iterable[Record], second: Iterable[Record], names: Sequence[str] = ()) -> list[Pair]:
    """Return the pairs of two runs: equal cells, or of two names the one of the first run against the other's second.

    ValueError when they share no cell, or were scored on different samples.
    """
    ours, theirs = usable(first), usable(second)
    crossed = len(names) == 2
    if crossed:
        ours = [r for r in ours if _named(r, names[0])]
        theirs = [r for r in theirs if _named(r, names[1])]
    elif names:
        ours, theirs = ([r for r in rows if any(_named(r, n) for n in names)] for rows in (ours, theirs))
    cells: dict[tuple[str, ...], Record] = {_cell(r, crossed): r for r in theirs}
    pairs = [(r, cells[_cell(r, crossed)]) for r in ours if _cell(r, crossed) in cells]
    if not pairs:
        raise ValueError("the two runs share no scored cell: expected the same task, variant, split, method and feed")
    return pairs


def across(records: Iterable[Record], variant: str, names: Sequence[str] = ()) -> list[Pair]:
    """Return each method on the other variants of a task, against itself on `variant`; the same split and data.

    ValueError for a variant or a name that is not there, or no method that was scored on two variants.
    """
    kept = usable(records)
    _known(names, kept)
    there = sorted({record.identity.variant for record in kept})
    if variant not in there:
        raise ValueError(f"no scored method on variant {variant!r}; there is {', '.join(there) or 'none'}")
    start = {_level(record): record for record in kept if record.identity.variant == variant}
    pairs = [
        (record, start[_level(record)])
        for record in kept
        if record.identity.variant != variant
        and _level(record) in start
        and (not names or any(_named(record, name) for name in names))
    ]
    if not pairs:
        raise ValueError(f"no method was scored on {variant!r} and on another variant of the same samples")
    return sorted(pairs, key=lambda pair: (protocol_of(pair[0]), -_goodness(pair[0])))


def compare_pairs(
    pairs: Sequence[Pair], tallies: tuple[Tallies, Tallies], near: Mapping[str, str], margin: float = MARGIN
) -> list[Versus]:
    """Return what may be said of each pair; `tallies` are those of the firsts and of the seconds, by key.

    `near` are the probe warnings by key (`audit.reached`).

    Scores without tallies on the same samples are compared by their intervals, and the result says so. ValueError for
    records of different samples or metrics.
    """
    made = [_compare(a, b, tallies, margin) for a, b in pairs]
    words: dict[int, Verdict] = {}
    for family in _families(pairs):
        words |= zip(family, verdicts([made[at][0] for at in family]), strict=True)
    result = []
    for at, ((a, b), (comparison, paired)) in enumerate(zip(pairs, made, strict=True)):
        d = comparison.difference
        coverage = coverage_warning(d.method, d.groups, d.value, difference=True)
        probes = tuple(f"{name_of(r)}: {near[r.key]}" for r in (a, b) if r.key in near)
        ratio, note = cost_ratio(a, b)
        result.append(Versus(a, b, comparison, words[at], paired, coverage, probes, ratio, note))
    return result


def cost_ratio(a: Record, b: Record) -> tuple[float | None, str]:
    """Return time a sample of `a` over that of `b`, or None and why not: no timing, different machines or ways."""
    if a.provenance.fingerprint != b.provenance.fingerprint:
        return None, "different machines"
    costs = [_cost(record) for record in (a, b)]
    if costs[0] is None or not costs[1]:
        return None, "not timed"
    if measured(a) != measured(b):
        return None, "timed in two ways"
    return costs[0] / costs[1], ""


def measured(record: Record) -> bool:
    """Whether the time was taken apart, a sample a call, with an interval, rather than in batches during the run."""
    return record.timing is not None and record.timing.predict_low_us is not None


def usable(records: Iterable[Record]) -> list[Record]:
    """Return the methods scored by a share with an interval; of equal cells on the same data the last started."""
    kept: dict[tuple[str, ...], Record] = {}
    for record in sorted(records, key=lambda r: r.provenance.started):
        scored = record.identity.role == "method" and record.status.state == "ok" and record.metrics
        if scored and record.metrics[0].unit == "fraction" and record.metrics[0].low is not None:
            kept[(*_cell(record), record.identity.dataset_hash)] = record
    return list(kept.values())


def _compare(a: Record, b: Record, tallies: tuple[Tallies, Tallies], margin: float) -> tuple[Comparison, bool]:
    who, other = a.identity, b.identity
    if (who.dataset_hash, who.protocol_version) != (other.dataset_hash, other.protocol_version):
        raise ValueError(
            f"{who.task}, {who.variant}: {name_of(a)} and {name_of(b)} were scored on different samples (dataset "
            f"{who.dataset_hash[:12]} and {other.dataset_hash[:12]}, protocol {who.protocol_version} and "
            f"{other.protocol_version}); run both on the same"
        )
    if a.metrics[0].name != b.metrics[0].name:
        raise ValueError(f"{who.task}: expected one metric, got {a.metrics[0].name!r} and {b.metrics[0].name!r}")
    ours, theirs = tallies[0].get(a.key), tallies[1].get(b.key)
    if ours is not None and theirs is not None and ours.samples == theirs.samples:
        return compare_groups(ours.groups, theirs.groups, margin), True
    return unpaired(a, b, margin), False


def unpaired(a: Record, b: Record, margin: float) -> Comparison:
    """Return a comparison from the two intervals alone: their ends combined as Newcombe does, tests by the normal law.

    Source: Newcombe, Statistics in Medicine 17 (1998), method 10.
    """
    x, y = a.metrics[0], b.metrics[0]
    assert x.low is not None
    assert x.high is not None  # `usable` keeps no others
    assert y.low is not None
    assert y.high is not None
    value = x.value - y.value
    down, up = hypot(x.value - x.low, y.high - y.value), hypot(x.high - x.value, y.value - y.low)
    z = float(ndtri(0.975))
    toward = (down if value > 0 else up) / z  # the arm that reaches for zero
    p = float(2 * ndtr(-abs(value) / toward)) if toward > 0 else float(value == 0)
    wide = max(down, up) / z
    above = float(ndtr(-(value + margin) / wide)) if wide > 0 else float(value <= -margin)
    below = float(ndtr((value - margin) / wide)) if wide > 0 else float(value >= margin)
    groups = min(x.groups, y.groups)
    interval = Interval(value, max(-1.0, value - down), min(1.0, value + up), 0.95, UNPAIRED, min(x.n, y.n), groups)
    return Comparison(interval, min(1.0, p), max(above, below), margin)


def _cost(record: Record) -> float | None:
    timing = record.timing
    if timing is None or timing.predict_us_per_sample is None:
        return None
    return timing.predict_us_per_sample + (timing.feature_us_per_sample or 0.0)


def _goodness(record: Record) -> float:
    metric = record.metrics[0]
    return metric.value if metric.direction == "higher" else -metric.value


def _named(record: Record, name: str) -> bool:
    return name_of(record) == name or (len(name) >= 6 and record.key.startswith(name))


def _known(names: Sequence[str], records: Sequence[Record]) -> None:
    for name in names:
        if not any(_named(record, name) for record in records):
            there = ", ".join(sorted({name_of(record) for record in records})) or "no scored method"
            raise ValueError(
                f"no scored method {name!r} (method@modality or the start of a record's key); there is {there}"
            )


def _cell(record: Record, crossed: bool = False) -> tuple[str, ...]:
    who = record.identity
    protocol = (who.task, who.variant, who.split)
    return protocol if crossed else (*protocol, who.method, fed_with(who.modality, who.params))


def _level(record: Record) -> tuple[str, ...]:
    """What two records share that differ in nothing but the variant."""
    who = record.identity
    fed = fed_with(who.modality, who.params)
    return who.task, who.split, who.dataset_hash, str(who.protocol_version), who.method, fed


def protocol_of(record: Record) -> tuple[str, ...]:
    """Return what two records must share to be compared."""
    who = record.identity
    return who.task, who.variant, who.split, who.dataset_hash, str(who.protocol_version)


def _protocols(records: Iterable[Record]) -> dict[tuple[str, ...], list[Record]]:
    found: dict[tuple[str, ...], list[Record]] = {}
    for record in records:
        found.setdefault(protocol_of(record), []).append(record)
    return found


def _families(pairs: Sequence[Pair]) -> Iterable[list[int]]:
    found: dict[tuple[str, ...], list[int]] = {}
    for at, (first, _) in enumerate(pairs):
        found.setdefault(protocol_of(first), []).append(at)
    return found.values()
