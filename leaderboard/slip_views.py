"""Slip records -> views: table IV beside ours, delays beside cost, what raises false alarms, conditions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from leaderboard.labels import beside
from leaderboard.names import SPLITS, title
from leaderboard.paper import TABLE_IV
from leaderboard.record import Record
from leaderboard.slip_cells import (
    area_cell,
    cost_cell,
    count_cell,
    dataset_note,
    delay_cell,
    difference_cell,
    percent_cell,
    plain_cell,
    rule_breaks,
    who_cells,
    words,
)
from leaderboard.slip_conditions import condition_views, rest_view
from leaderboard.slip_tables import SlipBlock, supported, verdicts
from leaderboard.slips import levels, metric, rates
from leaderboard.views import Cell, Column, View, breaks_of, paled, span

RATE = 1.0
"""False alarms a minute at which conditions are compared."""
_PAPER_NOTE = (
    "The paper counts the slips that were called slip, of 20 trials an object, with the covariance detector and beta "
    "from a prior slip; its intervals are 95 % Wilson intervals. Ours counts an alarm raised within the slip or up to "
    "0.25 s before; one that has been on since earlier is a false alarm, and the slip counts as missed."
)
_PAIRED = "difference of the medians, paired over trials; below zero is earlier"
_FOUND_NOTHING = "A detector that finds all slips and calls every trial without slip a slip has found nothing."
_INCIPIENT = "Incipient: slips in part and recovers, so that an alarm is neither a detection nor a false alarm."
_MISSED = "∞: most slips are missed at that threshold."


def slip_views(block: SlipBlock, conditions: bool = True) -> Iterator[View]:
    """The views of a block in the order of the page, with or without the conditions one by one; table IV apart."""
    for split in block.splits:
        yield from split_views(block, split, conditions)


def split_views(block: SlipBlock, split: str, conditions: bool = True) -> Iterator[View]:
    """The views of one split, delays first, each with its protocol and split; none where nothing was scored."""
    records = block.of(split)
    if not records:
        return
    views = [
        delay_view(block, split, records),
        called_view(block, split, records),
        negatives_view(block, split, records),
        false_alarm_view(block, split, records),
        rest_view(block, split, records),
        *(condition_views(block, split, records) if conditions else ()),
    ]
    where = f"{block.protocol}, {title(SPLITS, split)}"
    yield from (replace(view, title=f"{view.title} · {where}") for view in views if view is not None)


def table_iv(block: SlipBlock) -> View | None:
    """The paper's table IV with ours below; None where the block is not of the paper's protocol."""
    if block.variant != "paper" or not block.task.startswith("slip/fvsight/"):
        return None
    shapes = [figure.shape for figure in TABLE_IV]
    paper = [Cell(f"{f.found}/{f.trials}", f"{100 * f.found / f.trials:.0f} %, {span(*f.interval)}") for f in TABLE_IV]
    found, trials = sum(f.found for f in TABLE_IV), sum(f.trials for f in TABLE_IV)
    rows = [(Cell("the paper"), Cell("a prior slip"), Cell("covariance"), *paper, Cell(f"{found}/{trials}"), Cell("–"))]
    for split in block.splits:
        for record in block.of(split):
            cells = [count_cell(metric(record, "detected", None, "object", shape)) for shape in shapes]
            cells += [count_cell(metric(record, "detected")), count_cell(metric(record, "false_alarm_trials"))]
            rows.append((Cell(title(SPLITS, split)), *who_cells(record), *cells))
    heads = ("Thresholds from", "Threshold", "Detector", *(shape.capitalize() for shape in shapes), "All")
    return View(
        id=f"slip-iv-{block.dataset_hash[:8]}",
        title=beside("Table IV of the paper beside ours: slips found", block.label),
        columns=(
            *(Column(head, at > 2, sortable=at < 3) for at, head in enumerate(heads)),
            Column("Trials with a false alarm", True, "outside the slip, in the time before and after", False),
        ),
        rows=paled(rows, 2),
        notes=(_PAPER_NOTE, *dataset_note(block)),
        header=2,
        breaks=breaks_of([row[0].text + row[1].text for row in rows]),
        kind=block.kind,
    )


def delay_view(block: SlipBlock, split: str, records: Sequence[Record]) -> View:
    """Onset delays at fixed rates of false alarms, paired against the baseline, beside area and cost."""
    asked = rates(records)
    columns = [Column("Threshold"), Column("Detector")]
    rows = []
    for rate in asked:
        mark = "" if all(supported(record, rate) for record in records) else " †"
        columns += [
            Column(f"Delay at {rate:g}/min, ms{mark}", True, "median over the slips, a miss counts as infinite"),
            Column(f"Less energy's{mark}", True, _PAIRED),
            Column(f"Found, %{mark}", True),
        ]
    areas = any(metric(record, "roc_area") for record in records)
    columns += [Column("ROC area", True, "by trial; no verdict")] if areas else []
    columns += [Column("µs, batch", True, "a sample on one thread"), Column("µs, stream", True, "from Python")]
    for record in records:
        cells = []
        for rate in asked:
            cells += [
                delay_cell(metric(record, "delay_ms", rate), record.key),
                difference_cell(record, rate),
                percent_cell(metric(record, "detected", rate)),
            ]
        cells += [area_cell(metric(record, "roc_area"))] if areas else []
        cells += [cost_cell(metric(record, name)) for name in ("batch_us", "stream_us")]
        rows.append((*who_cells(record), *cells))
    weak = [rate for rate in asked if not all(supported(record, rate) for record in records)]
    notes = [*verdicts(replace(block, records=tuple(records)))]
    if weak:
        said = ", ".join(f"{rate:g}" for rate in weak)
        notes.append(f"† {said} a minute: fewer than 30 false alarms are expected in these trials, an extrapolation.")
    notes += [_MISSED, "Intervals are 95 %, bootstrap over trials with the threshold set anew in each draw."]
    return View(
        id=f"slip-delay-{block.task}-{split}-{block.dataset_hash[:8]}".replace("/", "-"),
        title="Delay at fixed false alarms",
        columns=tuple(columns),
        rows=paled(rows, 1),
        notes=(*notes, *dataset_note(block)),
        header=1,
        breaks=rule_breaks(records),
        kind=block.kind,
    )


def negatives_view(block: SlipBlock, split: str, records: Sequence[Record]) -> View | None:
    """Delay where one kind of trial without slip disturbs at a time; None where the trials have no such kinds."""
    kinds = levels(records, "delay_ms", "negatives")
    if not kinds:
        return None
    rate = max(rates(records))
    columns = [Column("Threshold"), Column("Detector")]
    for kind in kinds:
        columns += [Column(f"{words(kind)}: delay, ms", True), Column("less energy's", True, _PAIRED)]
        columns += [Column("ROC area", True)]
    rows = []
    for record in records:
        cells = []
        for kind in kinds:
            cells += [
                delay_cell(metric(record, "delay_ms", rate, "negatives", kind), record.key),
                difference_cell(record, rate, "negatives", kind),
                area_cell(metric(record, "roc_area", None, "negatives", kind)),
            ]
        rows.append((*who_cells(record), *cells))
    return View(
        id=f"slip-negatives-{block.task}-{split}-{block.dataset_hash[:8]}".replace("/", "-"),
        title=f"Against one kind of disturbance at a time: delay at {rate:g} false alarms a minute",
        columns=tuple(columns),
        rows=paled(rows, 1),
        notes=(_MISSED, "The ROC area is shown beside the delay and is no verdict."),
        header=1,
        breaks=rule_breaks(records),
        kind=block.kind,
    )


def false_alarm_view(block: SlipBlock, split: str, records: Sequence[Record]) -> View | None:
    """False alarms a minute by kind of trial, where all trials together give one a minute; None with one kind."""
    kinds = levels(records, "false_alarms_per_min", "kind")
    if len(kinds) < 2:
        return None
    rows = [
        (
            *who_cells(record),
            *(plain_cell(metric(record, "false_alarms_per_min", RATE, "kind", kind)) for kind in kinds),
        )
        for record in records
    ]
    return View(
        id=f"slip-false-{block.task}-{split}-{block.dataset_hash[:8]}".replace("/", "-"),
        title=f"What raises false alarms: alarms a minute by kind of trial, at {RATE:g} a minute over all",
        columns=(Column("Threshold"), Column("Detector"), *(Column(words(kind), True) for kind in kinds)),
        rows=paled(rows, 1),
        notes=("Of trials with slip, the time before the slip and after it.",),
        header=1,
        breaks=rule_breaks(records),
        kind=block.kind,
    )


def called_view(block: SlipBlock, split: str, records: Sequence[Record]) -> View | None:
    """Table IV with hard negatives: slips found and trials without gross slip called slip; None without such trials."""
    kinds = levels(records, "called", "kind")
    if not kinds:
        return None
    shapes = levels(records, "detected", "object")
    rows = [
        (
            *who_cells(record),
            *(count_cell(metric(record, "detected", None, "object", shape)) for shape in shapes),
            count_cell(metric(record, "detected")),
            delay_cell(metric(record, "delay_ms"), record.key),
            plain_cell(metric(record, "false_alarms_per_min")),
            *(percent_cell(metric(record, "called", None, "kind", kind)) for kind in kinds),
        )
        for record in records
    ]
    hard = block.task.startswith("slip/hard/")
    title_of = "Table IV with hard negatives: " if hard else "Hard negatives: "
    beyond = ("Speeds, loads, directions and rotations beyond the paper's.",) if hard else ()
    heads = (*(f"{words(shape)}: found" for shape in shapes), "All slips found", "Delay, ms", "False alarms a minute")
    return View(
        id=f"slip-called-{block.task}-{split}-{block.dataset_hash[:8]}".replace("/", "-"),
        title=title_of + "slips found, and trials without slip called slip in %, at the threshold from other trials",
        columns=(
            Column("Threshold"),
            Column("Detector"),
            *(Column(head, True) for head in heads),
            *(Column(f"{words(kind)}, %", True) for kind in kinds),
        ),
        rows=paled(rows, 1),
        notes=(*beyond, _FOUND_NOTHING, _INCIPIENT, _MISSED),
        header=1,
        breaks=rule_breaks(records),
        kind=block.kind,
    )
