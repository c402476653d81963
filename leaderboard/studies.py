"""Studies: tasks whose variants or feeds are the levels of one question, shown as curves and as a table for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from leaderboard.frame import Row, latest, records_of
from leaderboard.names import METHODS, MODALITIES, SPLITS, order, title
from leaderboard.views import Cell, Column, View, breaks_of, paled, score_cell

ALONE = ("force", "image", "image-change", "change", "pixels-change", "force-series")
"""Feeds of one modality: their curves are broken lines."""


@dataclass(frozen=True)
class Level:
    """One place on an axis: rows of this variant, or of this feed; None takes any."""

    label: str
    variant: str | None = None
    modality: str | None = None

    def holds(self, row: Row) -> bool:
        """Whether a record's row stands at this level."""
        return self.variant in (None, row["variant"]) and self.modality in (None, row["modality"])


@dataclass(frozen=True)
class Panel:
    """One axis of a study; `by_feed` where the levels are feeds, so that a curve is a method alone.

    `feeds` are those that it shows, all where none is named.
    """

    title: str
    axis: str
    levels: tuple[Level, ...]
    by_feed: bool = False
    feeds: tuple[str, ...] = ()

    def placed(self, rows: Sequence[Row]) -> dict[tuple[str, str], dict[int, Row]]:
        """Rows by (feed, method) and level, in the board's order; the feed is empty where levels are feeds."""
        curves: dict[tuple[str, str], dict[int, Row]] = {}
        for row in sorted(rows, key=lambda row: (order(MODALITIES, row["modality"]), order(METHODS, row["method"]))):
            if self.feeds and row["modality"] not in self.feeds:
                continue
            for at, level in enumerate(self.levels):
                if level.holds(row):
                    feed = "" if self.by_feed else row["modality"]
                    curves.setdefault((feed, row["method"]), {})[at] = row
        return {name: curve for name, curve in curves.items() if not self._elsewhere(name[0], curve, curves)}

    def _elsewhere(self, feed: str, curve: dict[int, Row], curves: dict[tuple[str, str], dict[int, Row]]) -> bool:
        """Whether a feed of several modalities has but one level where other curves have more."""
        return (
            not self.by_feed
            and len(curve) == 1
            and feed not in ALONE
            and any(len(other) > 1 for other in curves.values())
        )


@dataclass(frozen=True)
class Study:
    """A task that asks one question at several levels."""

    task: str
    title: str
    caption: str
    panels: tuple[Panel, ...]


def _variants(name: str, axis: str, levels: dict[str, str], modality: str | None = None) -> Panel:
    return Panel(name, axis, tuple(Level(label, variant, modality) for variant, label in levels.items()))


def _feeds(name: str, feeds: dict[str, str]) -> Panel:
    return Panel(name, "detail of touch", tuple(Level(label, None, feed) for feed, label in feeds.items()), True)


_FEW = {f"presses-{n}": str(n) for n in (1, 2, 5, 9)}
_TOUCH = {"contact": "bit", "location": "place", "touched": "16 bits", "force": "taxels", "pressure": "map"}
_FED = {
    "force": "force",
    "image-change": "image change",
    "fused-change": "force + image change",
    "fused-change-equal": "force + image change, equal",
}

_FUSED = {
    "fused-equal": "force + frame",
    "fused-change-equal": "force + change of the frame",
    "fused-change": "force + change, weights chosen",
    "fused-pixels-change-equal": "force in time + pixels of the change",
}
_ALONE_OF = {"fused-equal": ("force", "image"), "fused-pixels-change-equal": ("force-series", "pixels-change")}
"""One modality of a way to fuse, where it is not force and the change of the frame."""


def _pairings(fused: str) -> tuple[Panel, ...]:
    """The axes of bad pairing for one way to put frame and force together, with the frame alone beside."""
    axes = {
        "clocks differ by up to, ms": {"paired": "0"} | {f"time-{ms}ms": str(ms) for ms in (100, 200, 300, 400)},
        "force of a press about so far away, mm": {"paired": "own"} | {f"place-{mm}mm": str(mm) for mm in (2, 4, 6)},
        "force of": {"paired": "itself", "press-other": "same object", "class-other": "another"},
        "force of, in testing alone": {
            "paired": "itself",
            "test-press": "same object",
            "test-class": "another",
        },
    }
    alone = _ALONE_OF.get(fused, ("force", "image-change"))
    return tuple(
        Panel(
            _FUSED[fused],
            axis,
            tuple(Level(label, variant) for variant, label in levels.items()),
            feeds=(fused, *alone),
        )
        for axis, levels in axes.items()
    )


STUDIES = (
    Study(
        "pairing/",
        "Accuracy against how badly frame and force are paired",
        "The force beside a frame is another one's, in training and in testing unless said; a panel names what of the "
        "frame is fused. Grey lines: the best of each modality alone, rightly paired.",
        tuple(panel for feed in _FUSED for panel in _pairings(feed)),
    ),
    Study(
        "robustness/",
        "Accuracy against faults that training never saw",
        "Learnt on clean presses; a fault is drawn for each tested press. Broken lines: one modality alone.",
        (
            _variants("dead taxels", "taxels of 16", {"clean": "0"} | {f"dead-{n}": str(n) for n in (1, 2, 4, 8)}),
            _variants(
                "gain drift", "relative spread, %", {"clean": "0"} | {f"gain-{p}pct": str(p) for p in (5, 10, 20, 40)}
            ),
            _variants("force noise", "N a taxel", {"clean": "0"} | {f"noise-{n}N": str(n) for n in (0.1, 0.2, 0.5)}),
            _variants("camera noise", "grey levels", {"clean": "0"} | {f"grain-{n}": str(n) for n in (1, 3, 10)}),
            _variants("lights", "off by up to, %", {"clean": "0"} | {f"light-{p}pct": str(p) for p in (5, 10, 20)}),
            _variants("blur", "pixels", {"clean": "0"} | {f"blur-{n}px": str(n) for n in (0.5, 1, 2)}),
            _variants(
                "camera drops out", "frame", {"clean": "live", "camera-frozen": "frozen", "camera-black": "black"}
            ),
            _variants("one modality gone", "without", {"clean": "nothing", "no-force": "force", "no-image": "camera"}),
        ),
    ),
    Study(
        "granularity/",
        "Accuracy against detail of touch",
        "Bit: is anything felt. Place: centroid of the load. 16 bits: which taxels feel. Map: the true pressure.",
        (
            _feeds("touch alone", _TOUCH),
            _feeds("touch and camera", {"change": "none"} | {f"change+{name}": text for name, text in _TOUCH.items()}),
        ),
    ),
    Study(
        "few-shot/",
        "Accuracy against presses to learn from",
        "Test presses are the same at every number. Random: ten draws within each sensor.",
        tuple(_variants(text, "presses of each object", _FEW, feed) for feed, text in _FED.items()),
    ),
)


def study_of(task: str) -> Study | None:
    """The study that a task id is a version of."""
    return next((study for study in STUDIES if task.startswith(study.task)), None)


def study_rows(cells: pd.DataFrame, task: str, kind: str) -> list[Row]:
    """Scored methods of a study, of records that differ only in parameters the last; empty for any other task."""
    if study_of(task) is None:
        return []
    kept = latest(cells)
    kept = kept[(kept["task"] == task) & (kept["kind"] == kind) & (kept["role"] == "method") & (kept["state"] == "ok")]
    return records_of(kept.dropna(subset=["value"]))


def study_levels(rows: Sequence[Row]) -> set[str | None]:
    """Variants that the curves of a study show, None among them where levels are feeds; empty without a curve."""
    study = study_of(rows[0]["task"]) if rows and study_views(rows) else None
    return {level.variant for panel in study.panels for level in panel.levels} if study else set()


def study_views(rows: Sequence[Row]) -> list[View]:
    """Return a table for each panel that has two levels: a row for each split, feed and method."""
    study = study_of(rows[0]["task"]) if rows else None
    if study is None:
        return []
    splits = sorted({row["split"] for row in rows}, key=lambda name: order(SPLITS, name))
    views = []
    for panel in study.panels:
        by_split = {split: panel.placed([row for row in rows if row["split"] == split]) for split in splits}
        lines = [
            (split, feed, method, curve)
            for split, placed in by_split.items()
            if any(len(curve) > 1 for curve in placed.values())
            for (feed, method), curve in placed.items()
        ]
        shown = sorted({at for *_, curve in lines for at in curve})
        if len(shown) > 1:
            views.append(_view(panel, lines, shown))
    return views


def _view(panel: Panel, lines: Sequence[tuple[str, str, str, dict[int, Row]]], shown: Sequence[int]) -> View:
    cells = [
        (
            Cell(title(SPLITS, split)),
            Cell(title(MODALITIES | _FED, feed) or panel.title),
            Cell(title(METHODS, method)),
            *(score_cell(curve.get(at, {})) for at in shown),
        )
        for split, feed, method, curve in lines
    ]
    return View(
        id=f"study-{panel.title}-{panel.axis}".replace(" ", "-").replace(",", ""),
        title=f"{panel.title.capitalize()}: {panel.axis}",
        columns=(
            *(Column(name) for name in ("Split", "Fed with", "Method")),
            *(Column(f"{panel.levels[at].label}, %", True) for at in shown),
        ),
        rows=paled(cells, 2),
        header=2,
        breaks=breaks_of([line[:2] for line in lines]),
    )
