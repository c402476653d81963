"""The page as a reader meets it: in a browser, by mouse, by keyboard, on a phone, in the dark, on paper."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from browser_records import HOSTILE, METHODS, suite

from leaderboard import build_board
from leaderboard.board import BoardFiles
from leaderboard.record import Record

RecordFactory = Callable[..., Record]
pytestmark = pytest.mark.slow
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium, found on the path or as playwright brings it."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="the package playwright is not installed")
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    with sync_api.sync_playwright() as playwright:
        own = Path(playwright.chromium.executable_path)
        if found is None and not own.exists():
            pytest.skip(f"no browser: none of {', '.join(BROWSERS)} on the path, and playwright has brought none")
        started = playwright.chromium.launch(executable_path=found or str(own), args=["--no-sandbox"])
        yield started
        started.close()


@pytest.fixture(scope="module")
def board(make_record: RecordFactory, tmp_path_factory: pytest.TempPathFactory) -> BoardFiles:
    records, tallies = suite(make_record)
    out = tmp_path_factory.mktemp("board")
    return build_board(records, out, generated=datetime(2026, 3, 4, tzinfo=UTC), tallies=tallies)


class Visit:
    """An open page with what it said on the console and what it asked of the network."""

    def __init__(self, browser: Any, board: BoardFiles, **context: Any) -> None:
        self.context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **context})
        self.page = self.context.new_page()
        self.errors: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda m: self.errors.append(m.text) if m.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("dialog", lambda dialog: self.errors.append(f"dialog: {dialog.message}") or dialog.dismiss())
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.address = board.html.as_uri()
        self.page.goto(self.address)

    def close(self) -> None:
        self.context.close()
        assert self.errors == []
        assert {url.partition("#")[0] for url in self.asked} == {self.address}


@pytest.fixture
def visit(browser: Any, board: BoardFiles) -> Iterator[Callable[..., Any]]:
    """Open the page; at the end it must have been silent and offline."""
    opened: list[Visit] = []

    def go(**context: Any) -> Any:
        opened.append(Visit(browser, board, **context))
        return opened[-1].page

    yield go
    for one in opened:
        one.close()


def _column(table: Any, at: int) -> list[float]:
    """Return the figures of a column from top to bottom, rows without one left out."""
    cells = table.locator(f"tbody tr > :nth-child({at + 1})")
    return cells.evaluate_all("cells => cells.filter(c => c.dataset.v).map(c => +c.dataset.v)")


def _numeric(table: Any, title: str) -> tuple[int, Any]:
    heads = table.locator("thead th")
    at = next(i for i, text in enumerate(heads.all_inner_texts()) if text.startswith(title))
    return at, heads.nth(at)


def test_a_table_sorts_by_click_and_by_keyboard(visit: Callable[..., Any]) -> None:
    page = visit()
    table = page.locator("#paper table.sortable").first
    at, head = _numeric(table, "Ours, random split")
    before = _column(table, at)
    head.locator("button").click()
    assert head.get_attribute("aria-sort") == "descending"
    assert _column(table, at) == sorted(before, reverse=True) != before
    head.locator("button").focus()
    page.keyboard.press("Enter")
    assert head.get_attribute("aria-sort") == "ascending"
    assert _column(table, at) == sorted(before)
    rank_at, rank = _numeric(table, "Rank")
    rank.locator("button").focus()
    page.keyboard.press("Space")
    assert rank.get_attribute("aria-sort") == "ascending"  # the best rank first
    assert head.get_attribute("aria-sort") is None
    assert _column(table, rank_at) == sorted(_column(table, rank_at))


def test_a_score_opens_its_record_and_escape_closes_it(visit: Callable[..., Any]) -> None:
    page = visit()
    link = page.locator("#paper td a[href^='#r-']").first
    key = str(link.get_attribute("href"))[3:]
    link.focus()
    page.keyboard.press("Enter")
    dialog = page.locator("#record-view")
    assert dialog.is_visible()
    text = dialog.inner_text()
    for said in ("accuracy", "µs a sample", "d" * 64, "parameters and choices", "rank", key):
        assert said in text
    page.keyboard.press("Escape")
    assert not dialog.is_visible()
    assert link.evaluate("node => node === document.activeElement")
    link.click()
    dialog.get_by_role("button", name="Close").click()
    assert not dialog.is_visible()


def test_points_of_the_plot_are_the_rows_of_the_csv(visit: Callable[..., Any], board: BoardFiles) -> None:
    page = visit()
    speed = next(path for path in board.csv if path.name == "speed.csv")
    with speed.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["task"] == "objects/deep/v1" and row["variant"] == "paper"]
    drawn = page.locator("#paper figure a.point").evaluate_all(
        "marks => marks.map(m => [m.dataset.key, +m.dataset.x, +m.dataset.y, !!m.querySelector('.dominated')])"
    )
    alone = {(row["key"], float(row["predict_us"]), float(row["error"])) for row in rows}
    whole = {(row["key"], float(row["total_us"]), float(row["error"])) for row in rows}
    assert len(rows) == 2 * 2 * len(METHODS)
    assert {tuple(point[:3]) for point in drawn} == alone | whole
    assert len(drawn) == 2 * len(rows)  # one panel for each feed, and one for all of them
    poor = {row["key"] for row in rows if row["method"] == "slow-and-poor"}
    assert {key for key, *_, dominated in drawn if dominated} >= poor
    assert {row["key"] for row in rows if row["dominated_by"]} >= poor
    page.locator("#paper figure a.point").first.focus()
    page.keyboard.press("Enter")
    assert page.locator("#record-view").is_visible()


def test_warnings_standings_and_hostile_text_are_seen_not_obeyed(visit: Callable[..., Any]) -> None:
    page = visit()
    assert page.locator("#paper td .flag").count() > 0
    for standing in ("verified", "self-reported", "flagged"):
        assert page.locator(f"td .badge.{standing}, th .badge.{standing}").count() > 0
    titles = page.locator("h3").all_inner_texts()
    assert any("self-reported submissions, apart" in title for title in titles)
    assert any("flagged submissions, apart" in title for title in titles)
    assert "Spearman" in page.locator("#beside").inner_text()
    assert page.locator("img").count() == 0
    assert HOSTILE in page.locator("body").text_content()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_shows_the_page_without_sideways_scrolling(visit: Callable[..., Any], scheme: str) -> None:
    page = visit(viewport={"width": 390, "height": 844}, color_scheme=scheme, has_touch=True, is_mobile=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.locator("#paper td a[href^='#r-']").first.tap()
    box = page.locator("#record-view").bounding_box()
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= 390


_LUMINANCE = """() => {
  const rgb = (text) => text.match(/[\\d.]+/g).map(Number);
  const linear = (v) => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => 0.2126 * linear(r / 255) + 0.7152 * linear(g / 255) + 0.0722 * linear(b / 255);
  const paper = light(rgb(getComputedStyle(document.body).backgroundColor));
  const ratio = (name) => {
    const style = getComputedStyle(document.querySelector(name));
    const ink = light(rgb(style.fill !== 'none' && name.includes('.mark') ? style.fill : style.color));
    return (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05);
  };
  const texts = ['p', 'td', '.dim', '.notes', '.flag', '.ci', 'thead th', 'a'];
  const marks = ['.mark.s0', '.mark.s3', '.mark.s6'];
  return [paper, Math.min(...texts.map(ratio)), Math.min(...marks.map(ratio))];
}"""


@pytest.mark.parametrize(("scheme", "dark"), [("light", False), ("dark", True)])
def test_text_and_marks_stand_out_from_the_paper(visit: Callable[..., Any], scheme: str, dark: bool) -> None:
    """WCAG AA: 4.5 for text, 3 for marks."""
    paper, text, marks = visit(color_scheme=scheme).evaluate(_LUMINANCE)
    assert (paper < 0.1) is dark
    assert text >= 4.5
    assert marks >= 3


def test_on_paper_tables_are_whole_and_controls_are_gone(visit: Callable[..., Any]) -> None:
    page = visit(color_scheme="dark")
    page.emulate_media(media="print", color_scheme="dark")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert not page.locator("nav").is_visible()
    assert page.locator("#paper table.sortable").first.is_visible()
    assert page.evaluate("getComputedStyle(document.querySelector('.scroll')).overflowX") == "visible"
