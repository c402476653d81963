"""Scores from predictions on disk: those of the run, and no model is called."""

import json
import shutil

import numpy as np
import pytest

from leaderboard.record import read_predictions, read_records
from tests.vtbench.run import small
from vtbench.run import check_run, rescore, run_suite


@pytest.fixture
def finished(log, tmp_path):
    """(run folder, its summary, its dataset): one good method that counts its fits, one that fails."""
    data = small.write(tmp_path / "set")
    methods = {"mine": small.own("Nearest", log=log.path), "bad": small.own("Raises")}
    summary = run_suite(small.suite(data, ["mine", "bad"], methods), tmp_path / "run", progress=False)
    return tmp_path / "run", summary, data


def by_key(records):
    return {record.key: record for record in records}


def test_rescoring_gives_the_scores_of_the_run_and_calls_no_model(finished, log, monkeypatch):
    out, summary, _ = finished
    fits = log()
    assert fits == 13
    monkeypatch.setattr("tests.vtbench.run.own_classifiers.Nearest.predict", None)
    again = rescore(out)
    assert log() == fits
    assert by_key(again.records) == by_key(summary.records)
    assert by_key(read_records(out)) == by_key(summary.records)
    assert (again.done, again.failed) == (2, 2)


def test_the_scores_come_from_the_predictions(finished):
    """Wiped metrics come back; other predictions score otherwise."""
    out, summary, _ = finished
    good = [record for record in summary.records if record.status.state == "ok"]
    for record in good:
        path = out / "runs" / record.key / "record.json"
        wrong = {"name": "accuracy", "value": 0.123, "n": 1, "groups": 1}
        path.write_text(json.dumps({**json.loads(path.read_text()), "metrics": [wrong]}))
    assert by_key(rescore(out).records) == by_key(summary.records)

    key = good[0].key
    arrays = read_predictions(out, key)
    truth = np.array([int(sample) % small.CLASSES for sample in arrays["sample_id"]])
    np.savez_compressed(out / "runs" / key / "predictions.npz", **{**arrays, "label": truth})
    assert by_key(rescore(out).records)[key].metrics[0].value == 1.0
    np.savez_compressed(out / "runs" / key / "predictions.npz", **{**arrays, "label": (truth + 1) % small.CLASSES})
    assert by_key(rescore(out).records)[key].metrics[0].value == 0.0


def one_line(out):
    with pytest.raises((ValueError, OSError)) as error:
        rescore(out)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_a_missing_dataset_is_one_clear_line(finished):
    out, _, data = finished
    before = {path: path.read_bytes() for path in out.glob("runs/*/*")}
    shutil.rmtree(data)
    assert str(data) in one_line(out)
    assert {path: path.read_bytes() for path in out.glob("runs/*/*")} == before
    assert any(str(data) in problem for problem in check_run(out))


def test_missing_or_broken_predictions_are_one_clear_line(finished):
    out, summary, _ = finished
    key = next(record.key for record in summary.records if record.status.state == "ok")
    file = out / "runs" / key / "predictions.npz"
    file.write_bytes(file.read_bytes()[:100])
    assert str(file) in one_line(out)
    assert any(str(file) in problem for problem in check_run(out))
    file.unlink()
    assert str(file) in one_line(out)


def test_a_folder_that_is_no_run_is_one_clear_line(tmp_path):
    assert "suite.yaml" in one_line(tmp_path)
    assert "suite.yaml" in one_line(tmp_path / "nowhere")


def test_samples_that_changed_since_are_refused_and_no_record_is_rewritten(finished):
    """Other presses under the same ids would score against the wrong truth."""
    out, _, data = finished
    before = {path: path.read_bytes() for path in out.glob("runs/*/*")}
    data.rename(data.with_name("old"))
    small.write(data, seed=9)
    assert "own" in one_line(out)
    assert {path: path.read_bytes() for path in out.glob("runs/*/*")} == before
