"""`vtbench time` as it is used: what it refuses, in one line, and that samples are taken once."""

import json

import pytest
import yaml

from tests.vtbench.run import small


@pytest.fixture(scope="module")
def presses(tmp_path_factory):
    return small.write(tmp_path_factory.mktemp("presses") / "set")


@pytest.fixture
def suite(presses, tmp_path):
    made = small.suite(presses, ["knn", "svm"], entry={"splits": ["random"]}).model_dump(mode="json")
    (tmp_path / "suite.yaml").write_text(yaml.safe_dump(made), encoding="utf-8")
    return tmp_path / "suite.yaml"


def test_what_is_no_finished_run_of_the_suite_is_refused(vtbench, refused, suite, tmp_path):
    out = tmp_path / "run"
    assert "found no suite.yaml" in refused("time", suite, "-o", out)
    assert vtbench("run", suite, "-o", out).code == 0
    assert "no name holds 'nope'; there are 'objects/" in refused("time", suite, "-o", out, "--only", "nope")
    assert "holds a run of the suite 'small', not of 'quick'" in refused("time", "quick", "-o", out)
    next(out.glob("runs/*/record.json")).unlink()
    assert f"1 of 2 cells are not run yet; `vtbench run {suite} -o {out}` goes on" in refused("time", suite, "-o", out)


@pytest.mark.slow
def test_samples_are_taken_once_and_the_counts_stand_beside_them(vtbench, suite, tmp_path):
    out = tmp_path / "run"
    assert vtbench("run", suite, "-o", out).code == 0
    words = ("time", suite, "-o", out, "--processes", "2", "--only", "svm", "--json")
    answer = vtbench(*words)
    assert answer.code == 0, answer.err
    told = json.loads(answer.out)
    (row,) = told["rows"]
    assert row["processes"] == 2
    assert row["us_one_low"] <= row["us_one"] <= row["us_one_high"]
    assert row["params"] > 0
    assert row["macs"] > 0
    assert row["kb"] > 4 * row["params"] / 1000
    assert told["control"]["what"] == row["what"]
    samples = {path: path.read_bytes() for path in out.glob("timings/*/*/*.json")}
    assert len(samples) == 4  # the method and its control
    next(iter(samples)).write_text("{", encoding="utf-8")  # one that was cut is taken again, the others are not
    assert vtbench(*words).code == 0
    changed = [path for path, before in samples.items() if path.read_bytes() != before]
    assert changed == [next(iter(samples))]
