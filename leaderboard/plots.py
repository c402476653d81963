"""The board's plots: error against speed, and accuracy against unknown pose, each rows of small panels.

A method has one colour and one shape on the whole page, so that neither has to be told from the other alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import pandas as pd
from markupsafe import Markup

from leaderboard import svg
from leaderboard.curves import dominant, front
from leaderboard.frame import Row, records_of
from leaderboard.judgement import Better
from leaderboard.names import CLASSIFIERS, DETECTORS, METHODS, MODALITIES, SPLITS, order, title
from leaderboard.svg import Scale
from leaderboard.views import FLAG, microseconds, number, span

SPEED_CAPTION = (
    "Lower left is better. Time is the method alone, a sample on one thread, on a logarithmic axis, where not said "
    "otherwise; whiskers are 95 % intervals; panels of a row share their error axis. The line is the Pareto front of "
    "the figures as they stand. A hollow mark is surely dominated: another method is faster, and its error is lower "
    "where intervals of the difference separate, all pairs together."
)
ALL_FEEDS = "all feeds, features included"
OWN_STYLE = 7
"""Colour and shape of methods that the board does not know."""
WIDTH, HEIGHT = 262.0, 232.0
LEFT, RIGHT, BOTTOM, TOP = 34.0, 256.0, 192.0, 44.0


@dataclass(frozen=True)
class Key:
    """One entry of a legend: what a colour and a shape stand for."""

    title: str
    css: str
    path: str


@dataclass(frozen=True)
class Strip:
    """Panels side by side: one split, a panel for each of what the methods are fed."""

    title: str
    panels: tuple[Markup, ...]


@dataclass(frozen=True)
class Figure:
    """Strips of panels with one legend; `caption` says what the axes and whiskers are."""

    id: str
    title: str
    caption: str
    strips: tuple[Strip, ...]
    legend: tuple[Key, ...]


def speed_figure(speed: pd.DataFrame, name: str, better: Better = frozenset()) -> Figure | None:
    """Return error against microseconds a sample, a strip for each split and machine; None without two points.

    `speed` holds the rows of one task, variant and dataset, as `curves.speed_table` gives them. A first panel has all
    feeds with their features; in each panel a line is the Pareto front of the figures as they stand, and a hollow mark
    a method that another beats surely in error, by `better`, and in time.
    """
    rows = [row for row in records_of(speed) if row["predict_us"]]
    if len(rows) < 2:
        return None
    x_range = svg.decades([row["predict_us"] for row in rows])
    whole = svg.decades([row["total_us"] for row in rows])
    many = len({row["fingerprint"] for row in rows}) > 1
    strips = []
    for (split, fingerprint), strip in _grouped(rows, "split", "fingerprint"):
        top = svg.nice_top(max(max(row["error"], row["error_high"] or 0) for row in strip) or 1.0)
        feeds = _grouped(strip, "modality")
        panels = [_speed_panel(strip, ALL_FEEDS, whole, top, better, "total_us")] if len(feeds) > 1 else []
        panels += [_speed_panel(part, title(MODALITIES, modality), x_range, top, better) for (modality,), part in feeds]
        where = f", machine {fingerprint[:12]}" if many else ""
        strips.append(Strip(title(SPLITS, split) + where, tuple(panels)))
    features = [row["feature_us"] for row in rows if row["feature_us"]]
    beside = f" Features add {_between(features)} to each sample that has a frame." if features else ""
    return Figure(
        id=f"speed-{name}",
        title="Error against speed",
        caption=f"{SPEED_CAPTION}{beside} A mark opens its record.",
        strips=tuple(strips),
        legend=legend(row["method"] for row in rows),
    )


def _speed_panel(
    rows: Sequence[Row], head: str, x_range: tuple[float, float], top: float, better: Better, time: str = "predict_us"
) -> Markup:
    x, y = Scale(*x_range, LEFT + 4, RIGHT - 8, log=True), Scale(0, top, BOTTOM, TOP)
    parts = [svg.frame(x, y, head, "time a sample", f"error, {rows[0]['unit']}", _duration)]
    edge = front(rows, time)
    parts.append(svg.polyline(stairs([(x(row[time]), y(row["error"])) for row in edge], x.stop), "front"))
    marks = []
    for row in rows:
        at, (css, shape) = x(row[time]), style(row["method"])
        if row["error_low"] is not None:
            parts.append(svg.whisker(at, y(max(0, row["error_low"])), y(row["error_high"]), css))
        if time == "predict_us" and row["predict_low_us"] and row["predict_high_us"]:
            height = y(row["error"])
            parts.append(
                svg.line(x(row["predict_low_us"]), height, x(row["predict_high_us"]), height, f"whisker {css}")
            )
        looks = f"{css} dominated" if dominant(row, rows, better, time) else css
        tip, data = _tip(row, time), (row[time], row["error"])
        marks.append(svg.point(at, y(row["error"]), shape, looks, tip, row["key"], data))
    return svg.drawing(WIDTH, HEIGHT, f"Error against speed, {head}", Markup("").join([*parts, *marks]))


def stairs(points: Sequence[tuple[float, float]], stop: float) -> list[tuple[float, float]]:
    """Return the corners of a front that falls from left to right, drawn on to `stop`."""
    corners = [points[0]]
    for (_, before), (x, y) in pairwise(points):
        corners += [(x, before), (x, y)]
    return [*corners, (stop, points[-1][1])]


def pose_figure(curve: pd.DataFrame, name: str) -> Figure | None:
    """Return accuracy by unknown shift, a strip for each split; None without two shifts.

    `curve` holds the rows of one task, as `curves.pose_curve` gives them. The upper line is dashed in every panel.
    """
    rows = records_of(curve)
    shifts = sorted({row["jitter_mm"] for row in rows})
    methods = [row for row in rows if row["role"] == "method"]
    if len(shifts) < 2 or not methods:
        return None
    upper = [row for row in rows if row["role"] == "upper-line"]
    strips = []
    for (split,), strip in _grouped(methods, "split"):
        above = [row for row in upper if row["split"] == split]
        panels = [_pose_panel(part, above, modality, shifts) for (modality,), part in _grouped(strip, "modality")]
        strips.append(Strip(title(SPLITS, split), tuple(panels)))
    dashed = (Key(title(MODALITIES, upper[0]["modality"]), "upper", "M-9,0H9"),) if upper else ()
    return Figure(
        id=f"pose-{name}",
        title="Accuracy against unknown pose",
        caption="Each press is shifted by up to so many millimetres that no training press tells; whiskers are 95 % "
        "intervals, set side by side.",
        strips=tuple(strips),
        legend=(*legend(row["method"] for row in methods), *dashed),
    )


def _pose_panel(rows: Sequence[Row], upper: Sequence[Row], modality: str, shifts: Sequence[float]) -> Markup:
    head = title(MODALITIES, modality)
    margin = (shifts[-1] - shifts[0]) * 0.07
    x, y = Scale(shifts[0] - margin, shifts[-1] + margin, LEFT, RIGHT), Scale(0, 100, BOTTOM, TOP)
    parts = [svg.frame(x, y, head, "unknown shift, mm", "accuracy, %", lambda value: f"{value:g}")]
    best = {s: max((row["value"] for row in upper if row["jitter_mm"] == s), default=None) for s in shifts}
    line = [(x(s), y(value)) for s, value in best.items() if value is not None]
    parts += [svg.polyline(line, "curve upper")] if line else []
    groups = _grouped(sorted(rows, key=lambda row: row["jitter_mm"]), "method")
    marks = []
    for place, ((method,), points) in enumerate(groups):
        dodge, (css, shape) = 2.5 * (place - (len(groups) - 1) / 2), style(method)
        placed = [(x(row["jitter_mm"]) + dodge, y(row["value"]), row) for row in points]
        parts.append(svg.polyline([(px, py) for px, py, _ in placed], f"curve {css}"))
        parts += [
            svg.whisker(px, y(row["low"]), y(row["high"]), css) for px, _, row in placed if row["low"] is not None
        ]
        marks += [
            svg.point(px, py, shape, css, _pose_tip(row), row["key"], (row["jitter_mm"], row["value"]))
            for px, py, row in placed
        ]
    return svg.drawing(WIDTH, HEIGHT, f"Accuracy against unknown pose, {head}", Markup("").join([*parts, *marks]))


def _grouped(rows: Sequence[Row], *names: str) -> list[tuple[tuple[str, ...], list[Row]]]:
    """Return the rows by the values of `names`, in the board's order of splits, modalities and methods."""
    known = {"split": SPLITS, "modality": MODALITIES, "method": METHODS}
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in names), []).append(row)
    return sorted(
        groups.items(),
        key=lambda item: [order(known.get(name, {}), value) for name, value in zip(names, item[0], strict=True)],
    )


def style(method: str) -> tuple[str, int]:
    """Return the style class and the shape of a method; classifiers and detectors never share a plot."""
    for names in (list(CLASSIFIERS), list(DETECTORS)):
        if method in names:
            colour, lap = names.index(method) % len(svg.SHAPES), names.index(method) // len(svg.SHAPES)
            return f"s{colour}", (colour + 3 * lap) % len(svg.SHAPES)
    return f"s{OWN_STYLE}", OWN_STYLE


def legend(methods: Iterable[str]) -> tuple[Key, ...]:
    """Return what colours and shapes stand for, in the board's order."""
    keys = []
    for name in sorted(set(methods), key=lambda name: order(METHODS, name)):
        css, shape = style(name)
        keys.append(Key(title(METHODS, name), css, svg.SHAPES[shape]))
    return tuple(keys)


def _between(times_us: Sequence[float]) -> str:
    low, high = min(times_us), max(times_us)
    digits = 1 if low < 10_000 else 0
    ends = sorted({f"{low / 1e3:.{digits}f}", f"{high / 1e3:.{digits}f}"}, key=float)
    return " to ".join(ends) + " ms"


def _duration(us: float) -> str:
    return f"{us:g} µs" if us < 1e3 else f"{us / 1e3:g} ms" if us < 1e6 else f"{us / 1e6:g} s"


def _tip(row: Row, time: str) -> str:
    error = f"{number(row['error'])} ({span(row['error_low'], row['error_high'])}) {row['unit']}"
    fed = f", {title(MODALITIES, row['modality'])}" if time == "total_us" else ""
    flag = f"; {FLAG} {row['probe']}" if row["probe"] else ""
    return f"{title(METHODS, row['method'])}{fed}: error {error}, {microseconds(row[time])} µs{flag}"


def _pose_tip(row: Row) -> str:
    score = f"{number(row['value'])} ({span(row['low'], row['high'])}) %"
    flag = f"; {FLAG} {row['probe']}" if row["probe"] else ""
    return f"{title(METHODS, row['method'])}, {row['jitter_mm']:g} mm: {score}{flag}"
