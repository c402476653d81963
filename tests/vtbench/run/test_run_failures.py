"""A method that fails, overruns or lies becomes a row with its reason, and spoils no other."""

import signal

import numpy as np
import pytest

from leaderboard.record import read_predictions
from tests.vtbench.run import small
from vtbench.run import run_suite
from vtbench.run.executor import attempt, run_all
from vtbench.tasks.base import NotPossibleError

WRONG = {
    "Raises": "ZeroDivisionError: no answer",
    "RaisesLate": "RuntimeError: lost its memory",
    "OneTooMany": r"shape \(21,\), expected \(20,\)",
    "Column": r"shape \(20, 1\), expected \(20,\)",
    "NaN": "not class indices 0..2",
    "UnseenLabel": "not class indices 0..2",
    "Negative": "not class indices 0..2",
    "Text": "not class indices 0..2",
    "Halves": "not class indices 0..2",
    "NaNScores": r"ValueError: decision_function\(\) gave NaN",
    "Exits": "SystemExit: no message",
}


@pytest.mark.parametrize(("name", "reason"), WRONG.items())
def test_a_wrong_answer_is_a_reason_of_one_line(name, reason):
    outcome = attempt(small.work(small.method(name), small.FORCE))
    assert outcome.state == "failed"
    assert outcome.predictions is None
    assert "\n" not in outcome.reason
    with pytest.raises(AssertionError, match=reason):
        raise AssertionError(outcome.reason)
    assert 0 < outcome.started <= outcome.finished


def test_class_indices_may_come_as_floats():
    whole, plain = (attempt(small.work(small.method(name), small.FORCE)) for name in ("WholeFloats", "Nearest"))
    assert (whole.state, whole.predictions["label"].dtype) == ("ok", np.int32)
    np.testing.assert_array_equal(whole.predictions["label"], plain.predictions["label"])


def test_a_cell_that_takes_too_long_is_stopped_and_the_next_one_runs():
    late = small.work(small.method("Nearest", delay_s=30), small.FORCE, key="late", timeout_s=0.2)
    outcomes = list(run_all([late, small.work(small.method("Nearest"), small.FORCE, key="next")], jobs=1))
    assert [(o.key, o.state) for o in outcomes] == [("late", "timeout"), ("next", "ok")]
    assert outcomes[0].reason == "took longer than 0.2 s (timeout_s of the suite)"
    assert outcomes[0].finished - outcomes[0].started < 25


def test_the_limit_ends_with_its_cell():
    """The alarm of a finished cell must not ring in what comes after."""
    assert attempt(small.work(small.method("Nearest"), small.FORCE, timeout_s=50)).state == "ok"
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_what_the_data_do_not_allow_is_skipped_and_not_failed(monkeypatch):
    def refuse(*_):
        raise NotPossibleError("too few\nsamples")

    monkeypatch.setattr("vtbench.run.evaluate.choose", refuse)
    outcome = attempt(small.work(small.method("Nearest"), small.FORCE))
    assert (outcome.state, outcome.reason) == ("skipped", "too few samples")


@pytest.fixture(scope="module")
def beside_bad_ones(presses, tmp_path_factory):
    """Runs with and without bad methods beside good ones."""
    good = {"good": small.own("Nearest")}
    bad = {name.lower(): small.own(name) for name in ("Raises", "OneTooMany", "NaN", "UnseenLabel")}
    folder = tmp_path_factory.mktemp("runs")
    alone = small.suite(presses, ["knn", "good"], good)
    mixed = small.suite(presses, [*bad, "knn", "good"], {**good, **bad})
    return (
        (folder / "alone", run_suite(alone, folder / "alone", progress=False)),
        (folder / "mixed", run_suite(mixed, folder / "mixed", progress=False)),
        bad,
    )


def test_bad_methods_are_rows_and_spoil_no_other(beside_bad_ones):
    (alone_path, alone), (mixed_path, mixed), bad = beside_bad_ones
    assert (mixed.total, mixed.failed) == (12, 8)
    assert {name for (name, _), state in small.states(mixed).items() if state == "failed"} == set(bad)
    there = {record.key: record for record in mixed.records}
    for record in alone.records:
        assert record.metrics == there[record.key].metrics
        a, b = (read_predictions(path, record.key) for path in (alone_path, mixed_path))
        np.testing.assert_array_equal(a["scores"] if "scores" in a else a["label"], b.get("scores", b["label"]))


def test_a_failed_row_has_its_reason_and_neither_score_nor_predictions(beside_bad_ones):
    _, (path, mixed), _ = beside_bad_ones
    failed = [record for record in mixed.records if record.status.state == "failed"]
    for record in failed:
        assert record.status.reason
        assert "\n" not in record.status.reason
        assert record.metrics == ()
        assert record.timing is None
        assert [file.name for file in (path / "runs" / record.key).iterdir()] == ["record.json"]
    lines = [line for line in mixed.lines() if line.startswith("failed: ")]
    assert {record.status.reason for record in failed} == {line.split(": ", 2)[2] for line in lines}


def test_a_split_that_the_data_do_not_allow_is_a_skipped_row(tmp_path):
    one_unit = small.write(tmp_path / "set", samples=16)
    summary = run_suite(small.suite(one_unit), tmp_path / "run", progress=False)
    assert small.states(summary) == {("knn", "random"): "ok", ("knn", "held-out-unit"): "skipped"}
    (reason,) = [r.status.reason for r in summary.records if r.status.state == "skipped"]
    assert "one unit only" in reason


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_process_that_dies_costs_its_own_cell_only(jobs, presses, tmp_path):
    suite = small.suite(presses, ["dies", "knn", "good"], {"dies": small.own("Dies"), "good": small.own("Nearest")})
    summary = run_suite(suite, tmp_path / "run", jobs=jobs, progress=False)
    assert {state for (name, _), state in small.states(summary).items() if name == "dies"} == {"failed"}
    assert {state for (name, _), state in small.states(summary).items() if name != "dies"} == {"ok"}
    assert all("process died" in r.status.reason for r in summary.records if r.status.state == "failed")


def test_a_changed_byte_ends_a_run_before_anything_is_kept_under_the_stated_hash(tmp_path):
    data = small.write(tmp_path / "set")
    shard = sorted(data.glob("shard-*.parquet"))[-1]
    content = bytearray(shard.read_bytes())
    content[len(content) // 2] ^= 1
    shard.write_bytes(content)
    with pytest.raises(ValueError, match=rf"{shard.name}: checksum is off"):
        run_suite(small.suite(data), tmp_path / "run", progress=False)
    assert not [*tmp_path.glob("run/runs/*"), *tmp_path.glob("run/features/*")]
