"""Slip records -> views of single conditions: speed, load, direction, kind; and of the noise at rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from leaderboard.record import Metric, Record
from leaderboard.slip_cells import both_cell, rule_breaks, who_cells, words
from leaderboard.slip_tables import SlipBlock
from leaderboard.slips import levels, metric, rates
from leaderboard.views import NOT_RUN, Cell, Column, View, paled

FACTORS = ("speed", "load", "direction", "kind")


def condition_views(block: SlipBlock, split: str, records: Sequence[Record]) -> Iterator[View]:
    """Delay and slips found by speed, load, direction and kind of slip.

    At the threshold from other trials, and at the highest rate of false alarms, where a quarter of some condition's
    slips is found by some detector: a table of misses alone is left out.
    """
    for factor in FACTORS:
        yield from _by_factor(block, split, records, factor, None)
    for factor in FACTORS:
        for rate in rates(records)[-1:]:
            if _most_found(records, rate, factor) >= 0.25:
                yield from _by_factor(block, split, records, factor, rate)


def _by_factor(
    block: SlipBlock, split: str, records: Sequence[Record], factor: str, rate: float | None
) -> Iterator[View]:
    found = levels(records, "delay_ms", factor)
    if len(found) < 2 or not any(metric(each, "delay_ms", rate, factor, found[0]) for each in records):
        return
    rows = [(*who_cells(each), *(_condition_cell(each, rate, factor, level) for level in found)) for each in records]
    at = "at the threshold from other trials" if rate is None else f"at {rate:g} false alarms a minute"
    yield View(
        id=f"slip-{factor}-{rate or 'own'}-{block.task}-{split}-{block.dataset_hash[:8]}".replace("/", "-"),
        title=f"By {factor}, {at}: median delay, ms (slips found)",
        columns=(Column("Threshold"), Column("Detector"), *(Column(words(level), True) for level in found)),
        rows=paled(rows, 1),
        header=1,
        breaks=rule_breaks(records),
        kind=block.kind,
    )


def _condition_cell(record: Record, rate: float | None, factor: str, level: str) -> Cell:
    return both_cell(metric(record, "delay_ms", rate, factor, level), metric(record, "detected", rate, factor, level))


def _most_found(records: Sequence[Record], rate: float, factor: str) -> float:
    found = levels(records, "detected", factor)
    shares = [metric(record, "detected", rate, factor, level) for record in records for level in found]
    return max((share.value for share in shares if share is not None), default=0.0)


def rest_view(block: SlipBlock, split: str, records: Sequence[Record]) -> View | None:
    """False alarms a sample at rest, before hold-on: asked of `cfar`, and measured; None where nothing was asked."""
    asked = [record for record in records if metric(record, "asked_rate")]
    if not asked:
        return None
    rows = []
    for record in asked:
        goal, measured = metric(record, "asked_rate"), metric(record, "rest_rate")
        apart = goal is not None and measured is not None and (measured.low or 0.0) > (goal.high or 0.0)
        rows.append(
            (
                who_cells(record)[1],
                _rate_cell(goal),
                _rate_cell(metric(record, "training_rest_rate")),
                _rate_cell(measured, apart),
                _gap_cell(goal, measured),
                _folds_cell(metric(record, "coloured")),
            )
        )
    return View(
        id=f"slip-rest-{block.task}-{split}-{block.dataset_hash[:8]}".replace("/", "-"),
        title="cfar: false alarms asked for and measured at rest, of 1,000 samples before hold-on",
        columns=(
            Column("Detector"),
            Column("Asked", True, "with the error of the threshold's own estimate, on white noise"),
            Column("Training rests", True, "block bootstrap"),
            Column("Test rests", True, "bootstrap over trials"),
            Column("Gap", True, "test rests less asked"),
            Column("Rests not white", True, "folds whose training rests are coloured or change in size"),
        ),
        rows=paled(rows, 0),
        notes=(
            "cfar takes the noise at rest for white and equally large throughout. Where it is not, the rate is off: a "
            "taxel's noise grows with its load, which differs from trial to trial and from object to object.",
        ),
        kind=block.kind,
    )


def _rate_cell(found: Metric | None, off: bool = False) -> Cell:
    if found is None or found.low is None or found.high is None:
        return Cell(NOT_RUN, tone="muted")
    detail = f"{1e3 * found.low:,.2f} to {1e3 * found.high:,.2f}"
    return Cell(f"{1e3 * found.value:,.2f}", detail, found.value, tone="bad" if off else "", hint=found.interval)


def _gap_cell(goal: Metric | None, measured: Metric | None) -> Cell:
    if goal is None or measured is None:
        return Cell(NOT_RUN, tone="muted")
    gap = 1e3 * (measured.value - goal.value)
    return Cell(f"{gap:+,.2f}".replace("-", "\N{MINUS SIGN}"), sort=gap)


def _folds_cell(found: Metric | None) -> Cell:
    return Cell(NOT_RUN, tone="muted") if found is None else Cell(f"{found.value * found.n:.0f} of {found.n} folds")
