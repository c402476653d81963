from __future__ import annotations

import csv
from collections.abc import Callable
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path

import pytest

from leaderboard import board_tables, build_board, format_console
from leaderboard.board import distinct, harmless, slug
from leaderboard.frame import records_frame
from leaderboard.record import Record, Verdict

RecordFactory = Callable[..., Record]
NOW = datetime(2026, 3, 4, 5, 6, tzinfo=UTC)
HOSTILE = "<img src=x onerror=alert(1)>\"'><script>alert(2)</script>{{ 7*7 }}"
HINT = "no recordings; run `vtbench fetch fabricslide16`"


class Page(HTMLParser):
    """What a browser would see: tags with attributes, ids, links, text."""

    void = frozenset({"meta", "img", "br", "hr", "input", "link"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in self.void:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attrs for name, attrs in self.tags if name == tag]


def _suite(make_record: RecordFactory) -> list[Record]:
    real = {"task": "texture/fabricslide16/v1", "variant": "public", "kind": "real", "modality": "spectrum"}
    held = Verdict(law="all alike", expected="100 %", observed="100 %", passed=True)
    records = [
        make_record(0.9, method=m, modality=f, split=s, us=us, params={"C": 1.0})
        for m, us in (("svm", 60), ("knn", 15))
        for f in ("force", "image")
        for s in ("random", "held-out-unit")
    ]
    records += [
        make_record(0.7 - mm / 20, 0.3, 0.8, task="objects/pose/v1", variant=f"jitter-{mm}mm") for mm in (0, 4, 8)
    ]
    records += [
        make_record(0.2, 0.1, 0.3, role="probe", modality="rest-frame"),
        make_record(1.0, 0.98, 1.0, role="law", variant="no-variation", verdict=held),
        make_record(state="skipped", reason=HINT, **real),
        make_record(state="failed", reason=HOSTILE, method=HOSTILE, dataset=HOSTILE, params={HOSTILE: HOSTILE}),
        make_record(0.5, 0.4, 0.6, task="objects/deep/v1", variant=HOSTILE, modality=HOSTILE, split=HOSTILE),
    ]
    return records


@pytest.fixture(scope="module")
def page(make_record: RecordFactory, tmp_path_factory: pytest.TempPathFactory) -> Page:
    out = tmp_path_factory.mktemp("board")
    files = build_board(_suite(make_record), out, problems=[f"x/record.json: left out: {HOSTILE}"], generated=NOW)
    return Page(files.html.read_text(encoding="utf-8"))


def test_files_of_a_board(make_record: RecordFactory, tmp_path: Path) -> None:
    files = build_board(_suite(make_record), tmp_path / "deep" / "er", generated=NOW)
    assert files.html.name == "index.html"
    assert files.markdown.name == "board.md"
    names = {path.name for path in files.csv}
    assert {"records.csv", "probes.csv", "laws.csv", "pose.csv", "speed.csv"} <= names
    assert any(name.startswith("paper-table-ii-") for name in names)
    assert sorted(p for p in tmp_path.rglob("*") if p.is_file()) == sorted([files.html, files.markdown, *files.csv])
    with files.csv[0].open(newline="", encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(_suite(make_record))


def test_same_records_give_the_same_bytes(make_record: RecordFactory, tmp_path: Path) -> None:
    a, b = (build_board(_suite(make_record), tmp_path / name, generated=NOW) for name in "ab")
    for one, other in zip([a.html, a.markdown, *a.csv], [b.html, b.markdown, *b.csv], strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_page_is_well_formed_and_its_ids_are_unique(page: Page) -> None:
    assert page.open == []
    ids = [attrs["id"] for _, attrs in page.tags if "id" in attrs]
    assert len(ids) == len(set(ids))
    links = {str(attrs["href"]) for attrs in page.all("a")}
    assert links
    assert all(link.startswith("#") and link[1:] in ids for link in links)


def test_page_needs_nothing_from_outside(page: Page) -> None:
    for tag, attrs in page.tags:
        assert tag not in {"link", "img", "iframe", "object", "embed", "base", "form"}
        assert "src" not in attrs
        assert not any(name.startswith("on") for name in attrs)
    policy = next(attrs["content"] for attrs in page.all("meta") if attrs.get("http-equiv"))
    assert policy is not None
    assert policy.startswith("default-src 'none'")
    style = "".join(page.text)
    assert "@import" not in style
    assert "url(" not in style


def test_text_of_records_is_escaped(page: Page) -> None:
    assert len(page.all("script")) == 1
    text = "".join(page.text)
    assert "<script>alert(2)</script>" in text  # seen, not obeyed
    assert "{{ 7*7 }}" in text


def test_tables_can_be_sorted_scrolled_and_read_aloud(page: Page) -> None:
    scrolled = [attrs for attrs in page.all("div") if attrs.get("class") == "scroll"]
    labelled = [attrs for attrs in scrolled if attrs.get("role")]
    assert labelled
    assert all(attrs["tabindex"] == "0" and attrs["aria-label"] for attrs in labelled)
    assert all(attrs.get("scope") in {"col", "row"} for attrs in page.all("th"))
    assert {attrs.get("data-sort") for attrs in page.all("th")} >= {"number", "text"}
    figures = [attrs for attrs in page.all("svg") if attrs.get("role") in {"img", "group"}]
    assert figures
    assert all(attrs["aria-label"] for attrs in figures)


def test_page_says_what_a_reader_must_know(page: Page) -> None:
    text = " ".join("".join(page.text).split())
    for said in (
        HINT,
        "assumed n = 270",
        "95 % Wilson intervals",
        "simulated",
        "real recordings",
        "A simulated score is no evidence about the real sensor",
        "x/record.json: left out",
        "98.39 in its text",
        "0123abc",
        "Example CPU",
        "numpy 2.0.0".replace(" ", "\xa0"),
        "2026-03-04",
    ):
        assert " ".join(said.split()) in text


def test_every_record_has_its_detail(make_record: RecordFactory, page: Page) -> None:
    ids = {attrs.get("id") for attrs in page.all("details")}
    assert {f"r-{record.key[:16]}" for record in _suite(make_record)} <= ids


def test_markdown_has_the_tables_and_no_html(make_record: RecordFactory, tmp_path: Path) -> None:
    text = build_board(_suite(make_record), tmp_path, generated=NOW).markdown.read_text(encoding="utf-8")
    assert "| force | SVM | 90.00 (85.8–93.0) | 90.0 (85.0–94.0) | 1–4 (a) | 90.0 (85.0–94.0) | 1–4 (a) | 60 |" in text
    assert "## objects/pose/v1 (simulated)" in text
    assert "<" not in text


def test_console_shows_tables_and_notices(make_record: RecordFactory) -> None:
    text = format_console(board_tables(_suite(make_record)))
    assert "Table II of the paper beside ours: deep presses, dataset press-paper (simulated)" in text
    assert "accuracy by unknown shift" in text
    assert "vtbench fetch fabricslide16" in text
    assert "\x1b" not in text


def test_an_empty_board_is_a_board(tmp_path: Path) -> None:
    files = build_board([], tmp_path, generated=NOW)
    assert files.csv == []
    assert Page(files.html.read_text(encoding="utf-8")).open == []
    assert format_console(board_tables([])) == "\n"


def test_of_equal_records_the_last_stands_and_machines_stay_apart(make_record: RecordFactory) -> None:
    old = make_record(0.1, 0.0, 0.2, started="2026-01-01T00:00:00+00:00")
    new, elsewhere = make_record(0.2, 0.1, 0.3), make_record(0.3, 0.2, 0.4, fingerprint="other")
    assert distinct([new, old, elsewhere]) == [new, elsewhere]


def test_spreadsheets_get_no_formulas(make_record: RecordFactory) -> None:
    frame = harmless(records_frame([make_record(method="=HYPERLINK(1)", modality="-x", value=0.5)]))
    assert list(frame["method"]) == ["'=HYPERLINK(1)"]
    assert list(frame["modality"]) == ["'-x"]
    assert list(frame["value"]) == [50.0]


@pytest.mark.parametrize("name", ["../../etc/passwd", "a/b\\c", "...", "", "x" * 400, "con\x00trol", "ünï"])
def test_file_names_stay_in_their_folder(name: str) -> None:
    made = slug(name)
    assert made
    assert len(made) <= 120
    assert not set(made) & set('/\\\x00 <>:"|?*')
    assert not made.startswith(".")


def test_an_unwritable_folder_is_an_oserror(make_record: RecordFactory, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError, match="file"):
        build_board([make_record()], tmp_path / "file")
