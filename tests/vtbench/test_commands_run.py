"""A run through the command line: run, run again, score, board, validate."""

import json

import numpy as np
import pytest
import yaml

from leaderboard.record import read_predictions, read_records, record_key, write_record
from leaderboard.submission import Submission
from tests.vtbench.data import fakes
from vtbench.data import Dataset, write_dataset
from vtbench.run.scoring import score, true_labels

CELLS = ("total", "done", "kept", "skipped", "failed", "timeout")


@pytest.fixture
def suite(tmp_path):
    """A suite file with one method of vtbench and one by import path, on a small dataset."""
    data = write_dataset(
        tmp_path / "set", fakes.FakeScene(), samples=26, simulate=fakes.simulate, describe=fakes.describe, seed=3
    )
    content = {
        "id": "mine",
        "title": "two methods",
        "datasets": [{"id": "own", "path": str(data)}],
        "entries": [
            {
                "task": "objects/interference/v1",
                "variants": ["own"],
                "splits": ["random"],
                "modalities": ["force"],
                "methods": ["knn", "mine"],
                "probes": False,
            }
        ],
        "methods": {"mine": {"estimator": "sklearn.neighbors:NearestCentroid", "params": {"shrink_threshold": None}}},
    }

    def write(**changes):
        path = tmp_path / "my-suite.yaml"
        path.write_text(yaml.safe_dump({**content, **changes}, sort_keys=False))
        return path

    return write


def test_a_run_is_done_once_and_everything_after_it_reads_its_files(vtbench, suite, tmp_path):
    out = tmp_path / "run"
    first = json.loads(vtbench("run", suite(), "-o", out, "--json").out)
    assert {name: first[name] for name in CELLS} == dict.fromkeys(CELLS, 0) | {"total": 2, "done": 2}
    assert {row["method"] for row in first["records"]} == {"knn", "mine"}
    assert all(row["state"] == "ok" and 0 <= row["low"] <= row["value"] <= row["high"] for row in first["records"])

    stamps = {path: path.stat().st_mtime_ns for path in out.glob("runs/*/*")}
    again = json.loads(vtbench("run", suite(), "-o", out, "--json").out)
    assert (again["done"], again["kept"]) == (0, 2)
    assert again["records"] == first["records"]
    assert {path: path.stat().st_mtime_ns for path in out.glob("runs/*/*")} == stamps
    assert "nothing to do" in vtbench("run", suite(), "-o", out).out

    scored = json.loads(vtbench("score", out, "--json").out)
    by_key = {row["key"]: row for row in first["records"]}
    assert {row["key"]: row for row in scored["records"]} == by_key

    assert vtbench("validate", out).out == f"{out}: ok (run, 2 records)\n"

    board = json.loads(vtbench("board", out, "-o", tmp_path / "board", "--json").out)
    assert board["records"] == 2
    assert "<!doctype html>" in (tmp_path / "board" / "index.html").read_text()
    assert board["markdown"] == str(tmp_path / "board" / "board.md")
    assert "mine" in (tmp_path / "board" / "board.md").read_text()


def test_the_tables_of_a_run_are_printed(vtbench, suite, tmp_path):
    out = tmp_path / "run"
    printed = vtbench("run", suite(), "-o", out).out
    assert "objects/interference/v1, own" in printed
    assert f"{out}: 2 of 2 cells run" in printed
    assert f"vtbench board {out} -o" in printed
    assert "2 cells scored again" in vtbench("score", out).out


def hand_in(out, data, name, right):
    """Beside a run the record of a model that names the objects of the first `right` groups, and no others."""
    (like,) = [record for record in read_records(out) if record.identity.method == "knn"]
    arrays, table = read_predictions(out, like.key), Dataset.open(data).columns(["id", "label"])
    truth = true_labels(arrays, table["id"].to_numpy().astype(str), table["label"].to_numpy())
    known = np.isin(arrays["group"], np.unique(arrays["group"])[:right])
    arrays["label"] = np.where(known, truth, truth + 1).astype(np.int32)
    who = like.identity.model_copy(update={"method": f"{name}@00000000"})
    given = {"identity": who, "key": record_key(who), "metrics": score(arrays, truth)}
    given["submission"] = Submission(id=name, title=name, status="verified")
    write_record(out, like.model_copy(update=given), arrays)


def test_the_tables_of_a_run_say_what_its_page_says(vtbench, suite, tmp_path):
    """Ranks come from the same pairs of samples, and models that were handed in compete."""
    out = tmp_path / "run"
    vtbench("run", suite(), "-o", out, "--json")
    for name, right in (("some", 12), ("more", 20)):
        hand_in(out, tmp_path / "set", name, right)
    printed = [vtbench(*words).out for words in (("run", suite(), "-o", out), ("score", out))]
    assert vtbench("board", out, "-o", tmp_path / "board").code == 0
    page = (tmp_path / "board" / "board.md").read_text(encoding="utf-8").replace("\\", "").splitlines()
    rows = {line.split(" | ")[1].split()[0]: line.split(" | ")[2:-1] for line in page if line.startswith("| force |")}
    assert rows["more"][1] == "1 (a)"  # from the intervals alone: 1–2
    for text in printed:
        lines = {
            words[0]: " ".join(words) for line in text.splitlines() if (words := line.replace("force", "").split())
        }
        for name, cells in rows.items():
            assert " ".join(cells).replace("(", "").replace(")", "") in lines[name].replace("(", "").replace(")", "")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"datasets": [{"id": "own", "scene": "fvsight-pres"}]}, "dataset own: unknown scene 'fvsight-pres'"),
        (
            {"datasets": [{"id": "own", "scene": "fvsight-press", "set": {"load.deep": 3}}]},
            "dataset own: ",
        ),
        ({"methods": {"mine": {"estimator": "sklearn.neighbors:NearestCentroi"}}}, "'NearestCentroid'"),
        ({"methods": {"mine": {"estimator": "sklern:X"}}}, "no module 'sklern'"),
        ({"methods": {"mine": {"estimator": "sklearn.svm:SVC", "params": {"D": 1}}}}, "'D'"),
        ({"methods": {"mine": {"estimator": "math:pi"}}}, "math:pi"),
        ({"methods": {}}, "unknown method 'mine'"),
    ],
)
def test_what_would_fail_later_is_refused_before_any_work(refused, suite, tmp_path, changes, message):
    path = suite(**changes)
    assert message in refused("run", path, "-o", tmp_path / "run")
    assert message in refused("validate", path)
    assert not (tmp_path / "run").exists()


def test_cells_that_fail_are_rows_and_exit_code_one(vtbench, suite, tmp_path):
    method = {"estimator": "sklearn.svm:SVC", "params": {"kernel": "nonsense"}}  # noticed in fit only
    answer = vtbench("run", suite(methods={"mine": method}), "-o", tmp_path / "run", "--json")
    assert answer.code == 1
    states = {row["method"]: row["state"] for row in json.loads(answer.out)["records"]}
    assert states == {"knn": "ok", "mine": "failed"}
    assert "nonsense" in vtbench("run", suite(methods={"mine": method}), "-o", tmp_path / "run").out


def test_a_broken_record_is_named_and_the_board_goes_on(vtbench, suite, tmp_path):
    out = tmp_path / "run"
    assert vtbench("run", suite(), "-o", out).code == 0
    broken = min(out.glob("runs/*/record.json"))
    broken.write_text("{")
    answer = vtbench("board", out, "-o", tmp_path / "board", "--json")
    assert answer.code == 0
    assert answer.err.startswith("vtbench: warning: ")
    assert str(broken) in answer.err
    assert json.loads(answer.out)["records"] == 1
    checked = vtbench("validate", out)
    assert checked.code == 2
    assert str(broken) in checked.err


def test_a_board_of_nothing_is_refused(refused, suite, vtbench, tmp_path):
    (tmp_path / "empty" / "runs").mkdir(parents=True)
    assert "no records to draw" in refused("board", tmp_path / "empty", "-o", tmp_path / "board")
    assert not (tmp_path / "board").exists()
