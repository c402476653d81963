"""Delay against cost of the slip detectors: what a faster alarm costs a sample."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from leaderboard import svg
from leaderboard.curves import front
from leaderboard.frame import OWN
from leaderboard.names import METHODS, MODALITIES, SPLITS, title
from leaderboard.plots import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, Figure, Strip, legend, stairs, style
from leaderboard.record import Record
from leaderboard.slip_cells import delay_text
from leaderboard.slip_tables import SlipBlock
from leaderboard.slips import MISSED_MS, metric, rates
from leaderboard.svg import Scale
from leaderboard.views import microseconds


def delay_figure(block: SlipBlock, split: str, name: str) -> Figure | None:
    """Median delay at each rate of false alarms against microseconds a sample; None without two points.

    A detector that misses most slips stands on the upper edge of its panel. Flagged submissions are not in it.
    """
    records = [record for record in block.of(split) if metric(record, "batch_us") and _competes(record)]
    if len(records) < 2:
        return None
    costs = [_value(record, "batch_us", None) for record in records]
    asked = rates(records)
    delays = [_value(record, "delay_ms", rate) for record in records for rate in asked]
    known = [delay for delay in delays if delay < MISSED_MS / 2]
    top = svg.nice_top(max([*known, 10.0]) * 1.15)
    bottom = -svg.nice_top(-min([*known, 0.0])) if min([*known, 0.0]) < 0 else 0.0
    strips = []
    for rule in dict.fromkeys(record.identity.modality for record in records):
        mine = [record for record in records if record.identity.modality == rule]
        panels = [_panel(mine, rate, svg.decades(costs), bottom, top) for rate in asked]
        strips.append(Strip(title(MODALITIES, rule), tuple(panels)))
    return Figure(
        id=f"delay-{name}",
        title="Delay against cost",
        caption=f"{title(SPLITS, split).capitalize()}. Lower left is better: median delay of the onset at a fixed "
        "number of false alarms a minute, and the time that a batch takes a sample on one thread; whiskers are 95 % "
        "intervals. A detector that misses most slips stands on the upper edge. The line is the "
        "Pareto front of the others, as their figures stand.",
        strips=tuple(strips),
        legend=legend([record.identity.method for record in records]),
    )


def _panel(records: Sequence[Record], rate: float, x_range: tuple[float, float], bottom: float, top: float) -> Markup:
    x, y = Scale(*x_range, LEFT + 4, RIGHT - 8, log=True), Scale(bottom, top, BOTTOM, TOP)
    head = f"{rate:g} false alarms a minute"
    parts = [svg.frame(x, y, head, "time a sample, µs", "median delay, ms", lambda value: f"{value:g}")]
    found = [{"us": _value(r, "batch_us", None), "error": _value(r, "delay_ms", rate)} for r in records]
    edge = front([row for row in found if row["error"] < MISSED_MS / 2], "us")
    if edge:
        parts.append(svg.polyline(stairs([(x(row["us"]), y(row["error"])) for row in edge], x.stop), "front"))
    marks = []
    for record in records:
        delay, cost = metric(record, "delay_ms", rate), _value(record, "batch_us", None)
        if delay is None:
            continue
        css, shape = style(record.identity.method)
        if delay.low is not None and delay.high is not None:
            low, high = (y(min(max(end, y.low), top)) for end in (delay.low, delay.high))
            parts.append(svg.whisker(x(cost), low, high, css))
        tip = f"{title(METHODS, record.identity.method)}: {delay_text(delay.value)} ms, {microseconds(cost)} µs"
        marks.append(svg.mark(x(cost), y(min(max(delay.value, y.low), top)), shape, css, tip))
    return svg.drawing(WIDTH, HEIGHT, f"Delay against cost, {head}", Markup("").join([*parts, *marks]))


def _value(record: Record, what: str, rate: float | None) -> float:
    found = metric(record, what, rate)
    return MISSED_MS if found is None else found.value


def _competes(record: Record) -> bool:
    return record.submission is None or record.submission.status in OWN
