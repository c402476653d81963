from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable

import pytest

from leaderboard import svg
from leaderboard.contents import board_tables
from leaderboard.curves import pose_curve, speed_table
from leaderboard.frame import records_frame
from leaderboard.plots import pose_figure, speed_figure
from leaderboard.record import Record
from leaderboard.sections import laws_view, pose_view, probe_views, result_view
from leaderboard.svg import Scale
from leaderboard.text import console_table, escape_markdown, printable
from leaderboard.views import Cell, Column, View, breaks_of, brief, microseconds, paled, score_cell, span

RecordFactory = Callable[..., Record]
SVG = "{http://www.w3.org/2000/svg}"


def test_scales_reach_their_ends_and_ticks_are_round() -> None:
    linear, log = Scale(0, 80, 200, 20), Scale(10, 1000, 0, 100, log=True)
    assert (linear(0), linear(80), linear(40)) == (200, 20, 110)
    assert (log(10), log(100), log(1000)) == pytest.approx((0, 50, 100))
    assert linear.ticks() == [0, 20, 40, 60, 80]
    assert log.ticks() == [10, 100, 1000]


@pytest.mark.parametrize("value", [0.003, 0.9, 7, 44, 81.3, 99.9, 100, 3e4])
def test_an_axis_ends_on_a_tick_above_its_value(value: float) -> None:
    top = svg.nice_top(value)
    ticks = Scale(0, top, 0, 1).ticks()
    assert top >= value
    assert ticks[-1] == pytest.approx(top)
    assert 3 <= len(ticks) <= 8


def test_decades_enclose_and_never_vanish() -> None:
    assert svg.decades([14, 700]) == (10, 1000)
    assert svg.decades([100]) == (100, 1000)


def test_labels_are_escaped() -> None:
    drawn = svg.drawing(1, 1, '"><script>', svg.text(0, 0, "<b>&") + svg.mark(0, 0, 0, "s0", "<i>"))
    root = ET.fromstring(drawn)
    assert [e.text for e in root.iter(f"{SVG}text")] == ["<b>&"]
    assert root.get("aria-label") == '"><script>'


def test_error_against_speed_has_a_point_a_method_and_whiskers(make_record: RecordFactory) -> None:
    records = [
        make_record(0.9, 0.8, 0.95, method=m, us=us, split=s)
        for m, us in (("ksc", 400), ("knn", 20), ("my-own", 90))
        for s in ("random", "held-out-unit")
    ]
    figure = speed_figure(speed_table(records_frame(records)), "x")
    assert figure is not None
    assert [strip.title for strip in figure.strips] == ["random split", "held-out unit"]
    assert [key.title for key in figure.legend] == ["KSC", "kNN", "my-own"]
    assert len({key.path for key in figure.legend}) == len({key.css for key in figure.legend}) == 3
    root = ET.fromstring(figure.strips[0].panels[0])
    points = [e for e in root.iter(f"{SVG}path")]
    assert len(points) == 3
    tips = [title.text or "" for point in points for title in point]
    assert "kNN: error 10.0 (5.0–20.0) %, 20 µs" in tips
    assert sum("whisker" in (e.get("class") or "") for e in root.iter(f"{SVG}line")) == 9


def test_speeds_of_two_machines_are_two_strips(make_record: RecordFactory) -> None:
    records = [make_record(method=m, fingerprint=f) for m in ("ksc", "knn") for f in ("aaa", "bbb")]
    figure = speed_figure(speed_table(records_frame(records)), "x")
    assert figure is not None
    assert [strip.title for strip in figure.strips] == ["random split, machine aaa", "random split, machine bbb"]


def test_one_point_makes_no_plot(make_record: RecordFactory) -> None:
    cells = records_frame([make_record()])
    assert speed_figure(speed_table(cells), "x") is None
    assert pose_figure(pose_curve(cells), "x") is None


def test_pose_curve_is_drawn_by_split_and_feed_with_its_upper_line(make_record: RecordFactory) -> None:
    at = {"task": "objects/pose/v1"}
    records = [
        make_record(0.9 - mm / 10, 0.0, 1.0, variant=f"jitter-{mm}mm", method=m, modality=f, **at)
        for mm in (0, 2, 8)
        for m in ("svm", "knn")
        for f in ("force", "image")
    ]
    records += [
        make_record(0.99, variant=f"jitter-{mm}mm", modality="true-displacement", role="upper-line", high=1.0, **at)
        for mm in (0, 8)
    ]
    curve = pose_curve(records_frame(records))
    figure = pose_figure(curve, "x")
    assert figure is not None
    (strip,) = figure.strips
    assert len(strip.panels) == 2
    root = ET.fromstring(strip.panels[0])
    assert len(list(root.iter(f"{SVG}polyline"))) == 3
    heights = [float(e.get("points", "").split()[0].split(",")[1]) for e in root.iter(f"{SVG}polyline")]
    assert heights[0] < heights[1]  # 99 % stands above 90 %
    view = pose_view(curve)
    assert [c.title for c in view.columns[3:]] == ["0 mm, %", "2 mm, %", "8 mm, %"]
    assert len(view.rows) == 5


def test_figures_as_a_reader_sees_them() -> None:
    assert [microseconds(v) for v in (3.44, 120.4, 5310, None)] == ["3.4", "120", "5,310", "–"]
    assert span(96.84, 99.6) == "96.8–99.6"
    assert span(None, 1) == ""
    assert breaks_of(["a", "a", "b", "b", "c"]) == {2, 4}
    assert brief("a\n b" + "x" * 500, 10) == "a bxxxxxx…"


def test_repeated_names_are_marked_only_below_their_first() -> None:
    rows = [(Cell("a"), Cell("x")), (Cell("a"), Cell("x")), (Cell("b"), Cell("x"))]
    marked = paled(rows, 2)
    assert [[cell.same for cell in row] for row in marked] == [[False, False], [True, True], [False, False]]


def test_a_row_without_a_score_says_what_became_of_it() -> None:
    cell = score_cell({"value": None, "state": "timeout", "reason": "took\nlonger than 3 s", "key": "k"})
    assert (cell.text, cell.hint, cell.tone, cell.sort) == ("timeout", "took longer than 3 s", "bad", None)
    assert score_cell({}).text == "–"


def test_result_view_shows_paper_ours_and_cost(make_record: RecordFactory) -> None:
    tables = board_tables([make_record(0.95, 0.92, 0.97, feature_us=5000)])
    view = result_view(tables.papers[0], tables.machines)
    titles = [column.title for column in view.columns]
    assert titles[2:5] == ["Paper, %", "Ours, random split, %", "Ours, held-out unit, %"]
    (row,) = (row for row in view.rows if row[3].text != "–")
    assert [cell.text for cell in row] == ["force", "SVM", "90.00", "95.0", "–", "120", "5,000"]
    assert [cell.detail for cell in row[2:4]] == ["85.8–93.0", "92.0–97.0"]
    assert any("assumed n = 270" in note for note in view.notes)


def test_mixed_machines_make_speeds_unsortable_and_say_whose(make_record: RecordFactory) -> None:
    records = [make_record(method="svm", fingerprint="a"), make_record(method="knn", fingerprint="b")]
    tables = board_tables(records)
    view = result_view(tables.papers[0], tables.machines)
    speed = next(i for i, column in enumerate(view.columns) if column.title == "µs a sample")
    assert not view.columns[speed].sortable
    assert {row[speed].detail for row in view.rows} == {"", "A", "B"}


def test_probe_and_law_views(make_record: RecordFactory) -> None:
    records = [
        make_record(0.9, 0.85, 0.95),
        make_record(0.2, 0.1, 0.3, role="probe", modality="rest-frame"),
        make_record(0.89, 0.8, 0.95, role="probe", modality="total-force", method="svm"),
        make_record(0.5, 0.4, 0.6, role="probe", modality="total-force", method="knn"),
        make_record(role="law", variant="no-variation", state="failed", reason="x"),
    ]
    tables = board_tables(records)
    (view,) = probe_views(tables.probes)
    assert [c.title for c in view.columns] == [
        "Variant",
        "Split",
        "Total force only, %",
        "Frame without contact, %",
        "Best method, %",
    ]
    assert [cell.text for cell in view.rows[0]] == ["paper", "random split", "⚠ 89.0", "20.0", "90.0"]
    (law,) = laws_view(tables.laws).rows
    assert law[4].text == "0 of 1 methods"
    assert [notice.kind for notice in tables.notices] == ["probe near", "missing"]


@pytest.mark.parametrize(
    "text", ["<script>", "a | b", "`x`", "[l](javascript:x)", "*b* _i_", "# h", "line\nbreak", "![i](http://x)", "&lt;"]
)
def test_markdown_from_records_is_plain_text(text: str) -> None:
    safe = escape_markdown(text)
    assert "<" not in safe
    assert "\n" not in safe
    for mark in "|`[]*_#!":
        assert f"{mark}" not in safe.replace(f"\\{mark}", "") or mark == "!"


def test_control_characters_do_not_reach_a_terminal() -> None:
    assert printable("a\x1b[31mb\r\x00\u202ec") == "a [31mb c"


def test_console_columns_are_aligned_and_cut() -> None:
    columns = (Column("Method"), Column("Score", True))
    rows = ((Cell("x" * 90), Cell("9.0", "1.0–9.5")), (Cell("é漢"), Cell("100.0", "99.0–100.0")))
    lines = console_table(View("v", "t", columns, rows), width=60).splitlines()
    assert "…" in lines[2]
    assert lines[2].rstrip().endswith("9.0    1.0–9.5")
    assert lines[3].endswith("100.0 99.0–100.0")
    assert lines[2].index("9.0 ") == lines[3].index("0.0 ") + 1  # one wide character takes two cells
