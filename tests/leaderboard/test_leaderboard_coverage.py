"""What nominal 95 % covers, by simulation: within 93 to 97 %, or the interval carries its warning."""

from __future__ import annotations

import runpy

import pytest

from leaderboard import statistics as st
from leaderboard.caution import EDGE, FEW, FEW_AND_UNEVEN, SOME, WIDE, coverage_warning
from leaderboard.coverage import HIGH, LOW, Coverage, Setting, coverage, settings

REPEATS = 300
SLACK = 3.8  # three standard errors


def test_every_group_count_in_use_is_simulated_near_a_hundred_percent() -> None:
    made = list(settings())
    assert {3, 5, 6, 10, 27, 270} <= {s.groups for s in made if s.accuracy == 0.99}
    assert {3, 5, 6, 10, 27, 270} <= {s.groups for s in made if s.gap}


def test_the_warning_goes_with_few_groups_edges_and_safe_sides() -> None:
    assert coverage_warning(st.STUDENT, 6, 0.8) == FEW
    assert coverage_warning(st.BOOTSTRAP, 27, 0.97) == EDGE
    assert coverage_warning(st.WILSON_EFFECTIVE, 270, 0.99) == WIDE
    assert coverage_warning(st.BOOTSTRAP, 270, 0.97) == ""
    assert coverage_warning(st.BOOTSTRAP, 27, 0.8) == ""
    assert coverage_warning(st.BOOTSTRAP, 10, 0.8) == SOME
    assert coverage_warning(st.STUDENT, 6, 0.01, difference=True) == FEW_AND_UNEVEN
    assert coverage_warning("", 3, 0.5) == ""


def test_a_bad_interval_without_a_warning_is_not_honest() -> None:
    setting = Setting(270, 1, 0.8, 0.01)
    assert Coverage(setting, 95.0, 0.0, "").honest
    assert Coverage(setting, 85.0, 100.0, "").honest
    assert not Coverage(setting, 85.0, 10.0, "").honest
    assert not Coverage(setting, 99.0, 0.0, "").honest


def told(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *words: str) -> tuple[object, str]:
    """Exit code and everything printed by the module run as a program."""
    monkeypatch.setattr("sys.argv", ["coverage", *words])
    with pytest.warns(RuntimeWarning, match=r"found in sys\.modules"), pytest.raises(SystemExit) as end:
        runpy.run_module("leaderboard.coverage", run_name="__main__")
    return end.value.code, "".join(capsys.readouterr())


def test_the_program_says_how_it_is_used_and_refuses_what_is_no_count(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    code, text = told(capsys, monkeypatch, "--help")
    assert code == 0
    assert "[repetitions]" in text
    for wrong in ("many", "0"):
        code, text = told(capsys, monkeypatch, wrong)
        assert code == 2
        assert text.splitlines()[-1].startswith("python -m leaderboard.coverage: error: ")


@pytest.mark.slow
@pytest.mark.parametrize(
    "setting",
    [
        Setting(3, 324, 0.95, 0.05),
        Setting(5, 60, 0.99, 0.05),
        Setting(6, 270, 0.99, 0.05),
        Setting(10, 27, 0.95, 0.2),
        Setting(10, 27, 0.8, 0.05),
        Setting(27, 10, 0.99, 0.05),
        Setting(270, 1, 0.99, 0.01),
        Setting(6, 270, 0.95, 0.05, gap=0.1),
        Setting(27, 10, 0.95, 0.2, gap=0.1),
    ],
    ids=lambda s: f"{s.groups}-{s.size}-{s.accuracy}-{s.alike}-{s.gap}",
)
def test_intervals_cover_or_warn(setting: Setting) -> None:
    got = coverage(setting, REPEATS)
    assert LOW - SLACK <= got.covered <= HIGH + SLACK or got.warned > 50
