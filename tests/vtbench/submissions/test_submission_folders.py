"""Folders that strangers hand in: every problem by its rule, nobody's mistake costs another, nobody is believed."""

import json
import shutil
import zipfile
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
import yaml

from leaderboard import build_board
from leaderboard.record import read_records, record_key, write_record
from leaderboard.submission import Submission, plain_text, slug, web_link
from tests.vtbench.onnx_eval import graphs
from tests.vtbench.run import small
from vtbench.cli import main
from vtbench.data import Dataset
from vtbench.submissions.checking import check_folder, check_folders, name_problem
from vtbench.submissions.predictions import class_indices, read_predictions_file
from vtbench.submissions.reading import understand
from vtbench.submissions.rules import RULES
from vtbench.submissions.score import Terms, evaluate_folder
from vtbench.yaml_file import parse_yaml

TASK = "objects/interference/v1"
ABOUT = {
    "id": "nearest-mean",
    "title": "Nearest mean of forces",
    "authors": ["A. Person", "B. Other"],
    "licence": "Apache-2.0",
    "trained_on": "own presses of the same objects",
    "link": "https://example.org/nearest-mean",
}


@pytest.fixture(scope="module")
def presses(tmp_path_factory):
    return small.write(tmp_path_factory.mktemp("handed") / "set")


@pytest.fixture(scope="module")
def table(presses):
    return Dataset.open(presses).columns(["id", "label", "object"])


@pytest.fixture
def hand_in(tmp_path, presses, table):
    """Make a folder: keys of its YAML replaced, its one entry too; with a model, predictions, or what is given."""

    def make(name="one", entry=None, files=None, **changes):
        folder = tmp_path / name
        folder.mkdir()
        about = {
            **ABOUT,
            "entries": [{"task": TASK, "variant": "own", **(entry or {"model": "model.onnx"})}],
            **changes,
        }
        (folder / "submission.yaml").write_text(yaml.safe_dump(about, allow_unicode=True))
        graphs.honest(folder / "model.onnx", Dataset.open(presses).force(), table["label"].to_numpy())
        for path, content in (files or {}).items():
            (folder / path).write_bytes(content if isinstance(content, bytes) else content.encode())
        return folder

    return make


def handed(ids, labels, **entry):
    """An entry of predictions, and its file."""
    rows = "".join(f"{sample},{label}\n" for sample, label in zip(ids, labels, strict=True))
    return {"entry": {"predictions": "p.csv", **entry}, "files": {"p.csv": f"sample_id,label\n{rows}"}}


def rules(folder):
    return [problem.rule for problem in check_folder(folder).problems]


def test_a_good_folder_has_no_problem(hand_in, capsys):
    assert main(["check", str(hand_in())]) == 0
    assert "ok (nearest-mean, 1 entry)" in capsys.readouterr().out


def test_the_docs_hold_every_rule_and_an_example_that_is_understood():
    text = (files("vtbench") / "docs" / "submitting.md").read_text()
    for rule in RULES:
        assert f"| {rule} |" in text
    example = text.split("```yaml\n")[1].split("```")[0]
    about = parse_yaml(example, Path("submission.yaml"))
    file, problems = understand(about.data, about.lines)
    assert not problems
    assert all(name_problem(entry) is None for entry in file.entries)


@pytest.mark.parametrize(
    ("changes", "rule", "words"),
    [
        ({"title": "<script>alert('x')</script>"}, "S003", "markup"),
        ({"title": "fine &#60;b&#62;"}, "S003", "markup"),
        ({"title": "red \x1b[31m"}, "S003", "U+001B"),
        ({"authors": ["left \u202eright"]}, "S003", "U+202E"),
        ({"title": "x" * 81}, "S002", "at most 80"),
        ({"link": "javascript:alert(1)"}, "S004", "https://"),
        ({"titel": "twice"}, "S002", "did you mean 'title'"),
        ({"licence": None}, "S002", "licence"),
        ({"authors": []}, "S002", "authors"),
        ({"id": "../x"}, "S002", "id"),
        ({"entries": [{"task": "objects/dep/v1", "model": "model.onnx"}]}, "S005", "objects/deep/v1"),
        ({"entries": [{"task": TASK, "variant": "papr", "model": "model.onnx"}]}, "S005", "'paper'"),
        ({"entries": [{"task": TASK, "split": "radom", "model": "model.onnx"}]}, "S005", "'random'"),
        ({"entries": [{"task": "slip/fvsight/v1", "predictions": "p.csv"}]}, "S005", "expected a model"),
        ({"entries": [{"task": TASK, "model": "../../etc/passwd"}]}, "S006", "inside the folder"),
        ({"entries": [{"task": TASK, "model": "/etc/passwd"}]}, "S006", "inside the folder"),
        ({"entries": [{"task": TASK, "model": "other.onnx"}]}, "S006", "found none"),
        ({"entries": [{"task": TASK}]}, "S002", "a model or predictions"),
        ({"entries": [{"task": TASK, "model": "model.onnx", "claimed": 97.0}]}, "S002", "claimed"),
    ],
)
def test_a_breach_is_told_by_its_rule(hand_in, changes, rule, words):
    problems = check_folder(hand_in(**changes)).problems
    assert [problem.rule for problem in problems] == [rule]
    assert words in str(problems[0])
    assert str(problems[0]).isprintable()
    assert RULES[rule] in str(problems[0])


def test_all_problems_are_listed_at_once(hand_in):
    found = rules(hand_in(title="<b>", link="ftp://x", licence="", extra=1))
    assert sorted(found) == ["S002", "S003", "S003", "S004"]  # an empty licence is no text


def test_a_folder_without_a_readable_file_is_told_so(tmp_path, hand_in):
    empty = tmp_path / "empty"
    empty.mkdir()
    assert rules(empty) == rules(tmp_path / "nowhere") == ["S001"]
    for content in (b"\xff\xfe", b"title: [", b"- a list", b"a: 1\na: 2", b"x" * 200_000):
        (empty / "submission.yaml").write_bytes(content)
        assert rules(empty) == ["S001"]


def test_links_out_of_the_folder_are_not_followed(hand_in, tmp_path):
    folder = hand_in()
    (folder / "model.onnx").rename(tmp_path / "secret.onnx")
    (folder / "model.onnx").symlink_to(tmp_path / "secret.onnx")
    assert rules(folder) == ["S006"]


def test_a_model_that_breaks_the_contract_is_told_before_any_run(hand_in):
    folder = hand_in()
    graphs.custom(folder / "model.onnx")
    problem = check_folder(folder).problems[0]
    assert problem.rule == "S008"
    assert "com.example.Rob" in problem.found


def test_the_same_entry_twice_is_one_too_many(hand_in):
    entry = {"task": TASK, "variant": "own", "model": "model.onnx"}
    assert rules(hand_in(entries=[entry, entry])) == ["S011"]


def test_ids_and_artifacts_given_twice_are_told_to_both(hand_in):
    one, two, three = hand_in("one"), hand_in("two"), hand_in("three", id="other")
    graphs.linear(three / "model.onnx")
    found = check_folders([one, two, three])
    assert [[problem.rule for problem in each.problems] for each in found] == [["S010"], ["S010"], []]
    (three / "model.onnx").write_bytes((one / "model.onnx").read_bytes())
    found = check_folders([one, three])
    assert [[problem.rule for problem in each.problems] for each in found] == [["S010"], ["S010"]]


def test_one_bad_folder_costs_no_other(hand_in, tmp_path, capsys):
    good = hand_in("good")
    bad = hand_in("bad", id="bad", title="<b>")
    assert main(["check", str(bad), str(good), str(tmp_path / "nowhere"), "--json"]) == 2
    told = {each["folder"].rsplit("/")[-1]: each for each in json.loads(capsys.readouterr().out)}
    assert {name: each["ok"] for name, each in told.items()} == {"bad": False, "good": True, "nowhere": False}
    assert told["bad"]["problems"][0]["rule"] == "S003"
    assert main(["check", str(bad)]) == 2
    assert "S003" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("sample_id,label\na,1\na,2\n", "found 'a' 2 times"),
        ("sample,label\na,1\n", "expected the column 'sample_id'"),
        ("sample_id,label,scroes\na,1,2\n", "unknown column"),
        ("sample_id,label\na\n", "line 2: expected 2 values, found 1"),
        ("sample_id,label\n", "found none"),
        ("", "expected the column"),
        (b"\xff\xfe\x00", "UTF-8"),
    ],
)
def test_a_csv_that_cannot_be_read_is_told_by_line(tmp_path, content, words):
    path = tmp_path / "p.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(ValueError, match=words):
        read_predictions_file(path)


def test_arrays_are_read_without_pickle_bombs_or_nan(tmp_path):
    path = tmp_path / "p.npz"
    np.savez(path, sample_id=np.array(["a", "b"]), scores=np.float32([[0, 1], [1, 0]]))
    assert read_predictions_file(path).labels.tolist() == ["1", "0"]
    np.savez(path, sample_id=np.array(["a", "b"]), scores=np.float32([[0, 1], [np.nan, 0]]))
    with pytest.raises(ValueError, match="1 of 2 rows"):
        read_predictions_file(path)
    np.savez(path, sample_id=np.array(["a", {}], object), label=np.array([0, 1]))
    with pytest.raises(ValueError, match="pickle"):
        read_predictions_file(path)
    np.savez(path, sample_id=np.array(["a", "b"]), label=np.array([0]))
    with pytest.raises(ValueError, match="one length"):
        read_predictions_file(path)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("sample_id.npy", bytes(201 * 2**20))
    assert path.stat().st_size < 2**20
    with pytest.raises(ValueError, match="unpacked"):
        read_predictions_file(path)
    path.write_bytes(b"no zip")
    with pytest.raises(ValueError, match="NumPy arrays"):
        read_predictions_file(path)


def test_labels_are_names_or_numbers_of_classes():
    assert class_indices(np.array(["pen", "0", "ball"]), ("ball", "pen")).tolist() == [1, 0, 0]
    with pytest.raises(ValueError, match=r"0\.\.1"):
        class_indices(np.array(["2"]), ("ball", "pen"))


def test_predictions_are_scored_and_never_verified(hand_in, presses, table, tmp_path):
    labels = table["object"].tolist()
    labels[0] = labels[1]
    claiming = hand_in(**handed(table["id"], labels, claimed=0.5))
    record = evaluate_folder(claiming, Terms(data=(presses,)), tmp_path / "out")[0]
    assert record.metrics[0].value == pytest.approx(1 - 1 / len(labels))
    assert record.submission.status == "flagged"
    assert "claimed 50.0 %" in record.submission.reason
    plain = hand_in("two", id="two", **handed(table["id"], table["label"]))
    assert evaluate_folder(plain, Terms(data=(presses,)), tmp_path / "out")[0].submission.status == "self-reported"


def test_a_folder_of_what_others_handed_in_is_whole_without_a_suite(hand_in, presses, table, tmp_path, capsys):
    out = tmp_path / "out"
    (record,) = evaluate_folder(hand_in(**handed(table["id"], table["label"])), Terms(data=(presses,)), out)
    failed = hand_in("none", id="none", **handed(["stranger"], [0]))
    assert evaluate_folder(failed, Terms(data=(presses,)), out)[0].status.state == "failed"
    assert main(["validate", str(out)]) == 0
    assert "ok (evaluations, 2 records)" in capsys.readouterr().out

    own = record.identity.model_copy(update={"method": "knn"})
    unowned = record.model_copy(update={"identity": own, "key": record_key(own), "submission": None})
    write_record(out, unowned)
    assert main(["validate", str(out)]) == 2
    assert "found no suite.yaml" in capsys.readouterr().err

    shutil.rmtree(out / "runs" / unowned.key)
    (out / "runs" / record.key / "predictions.npz").write_bytes(b"cut")
    assert main(["validate", str(out)]) == 2
    assert "predictions.npz" in capsys.readouterr().err


def test_predictions_that_do_not_fit_the_data_fail_with_a_reason(hand_in, presses, table, tmp_path):
    cases = {
        "fewer": (handed(table["id"][1:], table["label"][1:]), "1 tested samples have no prediction"),
        "others": (handed(["stranger"], [0]), "begins with 'stranger'"),
        "labels": (handed(table["id"], ["cat"] * len(table)), "found 'cat'"),
    }
    for name, (content, words) in cases.items():
        folder = hand_in(name, id=name, **content)
        record = evaluate_folder(folder, Terms(data=(presses,)), tmp_path / "out")[0]
        assert record.status.state == "failed"
        assert words in record.status.reason
    assert len(read_records(tmp_path / "out")) == len(cases)
    more = hand_in("more", id="more", **handed([*table["id"], "untested"], [*table["label"], 0]))
    assert evaluate_folder(more, Terms(data=(presses,)), tmp_path / "out")[0].metrics[0].value == 1.0


def test_a_bad_entry_leaves_the_others_their_records(hand_in, presses, tmp_path, capsys):
    entries = [
        {"task": TASK, "variant": "own", "model": "none.onnx"},
        {"task": TASK, "variant": "own", "split": "all", "model": "custom.onnx"},
        {"task": TASK, "variant": "own", "split": "held-out-unit", "model": "model.onnx", "claimed": 0.01},
    ]
    folder = hand_in(entries=entries)
    graphs.custom(folder / "custom.onnx")
    out = tmp_path / "out"
    assert main(["evaluate", str(folder), "--data", str(presses), "-o", str(out)]) == 1
    told = capsys.readouterr()
    assert "entry 1 left out: S006" in told.err
    states = {record.identity.split: record for record in read_records(out)}
    assert states["all"].status.state == "failed"
    assert states["held-out-unit"].status.state == "ok"
    assert states["held-out-unit"].submission.status == "flagged"
    assert states["held-out-unit"].submission.authors == ("A. Person", "B. Other")


def test_nothing_can_be_evaluated_of_a_folder_that_cannot_be_understood(hand_in, presses, tmp_path, capsys):
    line = ["--data", str(presses), "-o", str(tmp_path / "out")]
    assert main(["evaluate", str(hand_in(title="<b>")), *line]) == 2
    assert "vtbench check" in capsys.readouterr().err
    assert main(["evaluate", str(hand_in("two")), *line, "--task", TASK]) == 2
    hidden = hand_in("three", entry={"predictions": "p.csv"}, files={"p.csv": "sample_id,label\na,1\n"})
    assert main(["evaluate", str(hidden), "--hidden-seed", "5000000000", "-o", str(tmp_path / "out")]) == 2
    assert "hidden set" in capsys.readouterr().err


def test_what_a_record_shows_of_a_stranger_is_harmless_even_if_forged(tmp_path, hand_in, presses, table):
    """A record that did not come through the checks cannot bring markup either, and the page escapes what it shows."""
    with pytest.raises(ValueError, match="markup"):
        Submission(id="x", title="<img src=x onerror=alert(1)>", status="verified")
    for text in ("a\nb", "a\u200bb", "", "  "):
        with pytest.raises(ValueError, match="expected"):
            plain_text(text)
    assert plain_text("  k < 10, Ünïcode & more ") == "k < 10, Ünïcode & more"
    for link in ("http://a.b/c?d=e", "https://example.org"):
        assert web_link(link) == link
    for link in ('https://a.b/"onclick=', "//a.b", "data:text/html,x", "https://a b"):
        with pytest.raises(ValueError, match="https"):
            web_link(link)
    assert slug("<b>Ünï Net!</b>") == "b-uni-net-b"
    assert slug("///") == "model"
    folder = hand_in(title="k < 10 & 'more' \"quotes\"", **handed(table["id"], table["label"]))
    records = evaluate_folder(folder, Terms(data=(presses,)), tmp_path / "out")
    page = build_board(records, tmp_path / "board").html.read_text()
    assert "k < 10 & 'more'" not in page
