"""Curves of a study: a strip for each split, a panel for each axis, levels at equal distances."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from leaderboard import svg
from leaderboard.frame import Row
from leaderboard.names import METHODS, MODALITIES, SPLITS, order, title
from leaderboard.plots import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, Figure, Strip, legend, style
from leaderboard.studies import ALONE, Panel, study_of
from leaderboard.svg import Scale
from leaderboard.views import number, span


class _Steps(Scale):
    """Levels at 0, 1, 2 ..."""

    def ticks(self) -> list[float]:
        """One for each level."""
        return [float(at) for at in range(int(self.high) + 1)]


def study_figure(rows: Sequence[Row], name: str) -> Figure | None:
    """Return the curves of a study's rows (`studies.study_rows`); None where no axis has two levels."""
    study = study_of(rows[0]["task"]) if rows else None
    if study is None:
        return None
    strips, floor = [], _floor(rows)
    for split in sorted({row["split"] for row in rows}, key=lambda name: order(SPLITS, name)):
        part = [row for row in rows if row["split"] == split]
        panels = [drawn for panel in study.panels if (drawn := _panel(panel, part, floor)) is not None]
        if panels:
            strips.append(Strip(title(SPLITS, split), tuple(panels)))
    if not strips:
        return None
    caption = f"{study.caption} Whiskers are 95 % intervals, set side by side. A mark opens its record."
    return Figure(f"study-{name}", study.title, caption, tuple(strips), legend(row["method"] for row in rows))


def _floor(rows: Sequence[Row]) -> float:
    """Return where the axis of all panels begins: the twenty below everything that is drawn."""
    return min(80.0, 20 * (min(row["value"] if row["low"] is None else row["low"] for row in rows) // 20))


def _panel(panel: Panel, rows: Sequence[Row], floor: float) -> Markup | None:
    placed = panel.placed(rows)
    curves = {name: curve for name, curve in placed.items() if len(curve) > 1 or panel.by_feed}
    if not any(len(curve) > 1 for curve in curves.values()):
        return None
    last = len(panel.levels) - 1
    x, y = _Steps(-0.25, last + 0.25, LEFT, RIGHT), Scale(floor, 100, BOTTOM, TOP)
    labels = [level.label for level in panel.levels]
    parts = [svg.frame(x, y, panel.title, panel.axis, "accuracy, %", lambda at: labels[int(at)])]
    mixed = len({feed for feed, _ in curves}) > 1
    marks = []
    for place, ((feed, method), curve) in enumerate(curves.items()):
        dodge, (css, shape) = 2.5 * (place - (len(curves) - 1) / 2), style(method)
        points = [(x(at) + dodge, row) for at, row in sorted(curve.items())]
        looks = f"curve {css} alone" if mixed and feed in ALONE else f"curve {css}"
        parts.append(svg.polyline([(px, y(row["value"])) for px, row in points], looks))
        parts += [svg.whisker(px, y(row["low"]), y(row["high"]), css) for px, row in points if row["low"] is not None]
        marks += [
            svg.point(px, y(row["value"]), shape, css, _tip(row, labels[at]), row["key"], (at, row["value"]))
            for (px, row), at in zip(points, sorted(curve), strict=True)
        ]
    parts += _references([(name[0], curve) for name, curve in placed.items() if name not in curves], x, y)
    return svg.drawing(WIDTH, HEIGHT, f"Accuracy, {panel.title}, {panel.axis}", Markup("").join([*parts, *marks]))


def _references(single: Sequence[tuple[str, dict[int, Row]]], x: Scale, y: Scale) -> list[Markup]:
    """The best of each modality that was scored at one level only, as a line across the panel."""
    best: dict[str, float] = {}
    for feed, curve in single:
        value = max(row["value"] for row in curve.values())
        best[feed] = max(best.get(feed, 0.0), value)
    parts = []
    for feed, value in best.items():
        parts.append(svg.polyline([(x.start, y(value)), (x.stop, y(value))], "curve upper"))
        parts.append(svg.text(x(0.5), y(value) - 3, title(MODALITIES, feed), "reference"))
    return parts


def _tip(row: Row, label: str) -> str:
    score = f"{number(row['value'])} ({span(row['low'], row['high'])}) %"
    return f"{title(METHODS, row['method'])}, {title(MODALITIES, row['modality'])}, {label}: {score}"
