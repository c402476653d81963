"""What README and the docs name is there: commands, suites, files. Their examples run in `test_docs_examples`."""

import re
from pathlib import Path

import pytest

from vtbench.cli import build_parser
from vtbench.config import suite_names

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "vtbench" / "docs").glob("*.md"))]


def commands() -> set[str]:
    """Names of the commands that `vtbench` has."""
    (choices,) = [action.choices for action in build_parser()._actions if action.dest == "command"]
    return set(choices)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files(page):
    targets = re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
    lost = [target for target in targets if "://" not in target and not (page.parent / target).exists()]
    assert lost == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_exist(page):
    named = set(re.findall(r"(?:^|`)vtbench ([a-z][a-z-]+)", page.read_text(encoding="utf-8"), flags=re.MULTILINE))
    assert named <= commands()


def test_the_list_of_commands_is_whole():
    section = PAGES[0].read_text(encoding="utf-8").split("## Commands")[1].split("\n\nEach")[0]
    assert set(re.findall(r"`([a-z-]+)`", section)) == commands()


def test_the_suites_are_all_named():
    section = PAGES[0].read_text(encoding="utf-8").split("## Commands")[1].split("## Sources")[0]
    assert set(suite_names()) <= set(re.findall(r"`([a-z-]+)`", section))


def test_nothing_is_left_to_fill_in():
    for page in PAGES:
        assert not re.search(r"@[A-Z]{3,}@|TODO|TBD", page.read_text(encoding="utf-8")), page.name
