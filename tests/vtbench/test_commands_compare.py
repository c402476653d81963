"""`vtbench compare` and `vtbench board --baselines` on the records that come with the package."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from leaderboard.baselines import read_baselines
from leaderboard.record import record_key, write_record
from leaderboard.tally import write_tally
from vtbench.cli import main

DEEP = "objects/deep/v1"
ALWAYS_WRONG = ("knn", "force", "random")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Force and image on deep presses, one method made wrong on every press; the same with another hash."""
    records, tallies = read_baselines()
    one, other = tmp_path_factory.mktemp("one"), tmp_path_factory.mktemp("other")
    for record in records:
        if record.identity.task == DEEP and record.identity.modality in ("force", "image"):
            counted = tallies[record.key]
            if (record.identity.method, record.identity.modality, record.identity.split) == ALWAYS_WRONG:
                wrong = record.metrics[0].model_copy(update={"value": 0.0, "low": 0.0, "high": 0.02})
                record = record.model_copy(update={"metrics": (wrong, *record.metrics[1:])})
                counted = counted.model_copy(update={"total": (0.0,) * len(counted.total)})
            write_tally(write_record(one, record), counted)
            identity = record.identity.model_copy(update={"dataset_hash": "0" * 64})
            write_record(other, record.model_copy(update={"identity": identity, "key": record_key(identity)}))
    return one, other


def test_compare_prints_differences_and_verdicts(runs, capsys):
    assert main(["compare", str(runs[0]), "--task", DEEP, "--split", "random"]) == 0
    text = capsys.readouterr().out
    (line,) = (line for line in text.splitlines() if " knn@force " in line)
    assert "first better" in line
    assert "Holm-adjusted" in text


def test_a_split_of_few_units_says_what_its_interval_is_worth(runs, capsys):
    assert main(["compare", str(runs[0]), "--task", DEEP, "--split", "held-out-unit"]) == 0
    assert "fewer than ten groups" in capsys.readouterr().out


def test_compare_as_json_is_paired_and_holm_never_lowers_p(runs, capsys):
    assert main(["compare", str(runs[0]), "--methods", "ksc@force", "svm@force", "svm@image", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert len(rows) == 2 * 3
    assert all(row["paired"] and row["p_holm"] >= row["p"] for row in rows)
    assert all(row["low"] <= row["difference"] <= row["high"] for row in rows)


def test_a_run_compared_with_itself_differs_in_nothing(runs, capsys):
    assert main(["compare", str(runs[0]), str(runs[0]), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert rows
    assert {row["difference"] for row in rows} == {0.0}
    assert {row["cost_ratio"] for row in rows} == {1.0}
    assert not {row["verdict"] for row in rows} & {"first better", "second better"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["{one}", "{other}"], "scored on different samples"),
        (["{one}", "--task", "no/such/v1"], "no record of the task 'no/such/v1'; there is objects/deep/v1"),
        (["{one}", "--methods", "nobody@force"], "no scored method 'nobody@force'"),
        (["{one}", "--margin", "0"], "expected percentage points between 0 and 100"),
        (["{one}", "{one}", "{one}"], "expected one run or two, got 3"),
        (["{one}/nothing"], "expected the folder of a run"),
    ],
)
def test_what_cannot_be_compared_is_one_line(runs, capsys, arguments, said):
    assert main(["compare", *(a.format(one=runs[0], other=runs[1]) for a in arguments)]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_the_baselines_make_a_board_alone_or_beside_a_run(runs, tmp_path, capsys):
    assert main(["board", "--baselines", "-o", str(tmp_path / "alone"), "--json"]) == 0
    alone = json.loads(capsys.readouterr().out)["records"]
    assert main(["board", str(runs[0]), "--baselines", "-o", str(tmp_path / "both"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["records"] == alone > 50  # the run's cells are the same ones
    assert "Table II of the paper beside ours" in (tmp_path / "both" / "board.md").read_text()
    assert main(["board", "-o", str(tmp_path)]) == 2
    assert "--baselines" in capsys.readouterr().err
