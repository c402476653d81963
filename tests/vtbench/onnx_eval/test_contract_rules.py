"""The parts of an evaluation that need no process: contract, messages, plans, verdicts, hidden seeds."""

import json
from dataclasses import replace

import numpy as np
import pytest

from leaderboard.submission import Latency
from vtbench.onnx_eval import channel, hidden, plan
from vtbench.onnx_eval.contract import Contract, Port, breaches
from vtbench.onnx_eval.judge import judge
from vtbench.onnx_eval.sandbox import Answer, Job

CONTRACT = Contract(
    (Port("force", "float32", ("N", 16)), Port("image", "uint8", ("N", 8, 8, 3))), Port("scores", "float32", ("N", 4))
)
FORCE, SCORES = Port("force", "float32", (None, 16)), Port("scores", "float32", (None, 4))


@pytest.mark.parametrize(
    ("inputs", "outputs", "words"),
    [
        ([FORCE], [SCORES], []),
        ([replace(FORCE, shape=None)], [replace(SCORES, shape=None), Port("label", "int64", None)], []),
        ([], [SCORES], ["no input", "force (N, 16) float32"]),
        ([replace(FORCE, dtype="float64")], [SCORES], ["expected float32, found float64", "Cast"]),
        ([replace(FORCE, shape=(None, 12))], [SCORES], ["expected 16 on axis 1, found 12"]),
        ([replace(FORCE, shape=(1, 16))], [SCORES], ["axis 0 (N) to be free, found 1", "dynamic"]),
        ([replace(FORCE, shape=(None, 4, 4))], [SCORES], ["number of axes"]),
        ([FORCE, Port("imag", "uint8", None)], [SCORES], ["rename it to 'image'"]),
        ([FORCE], [], ["'scores' is missing"]),
    ],
)
def test_a_breach_says_what_was_expected_what_was_found_and_what_helps(inputs, outputs, words):
    found = breaches(CONTRACT, inputs, outputs)
    assert len(found) == (1 if words else 0)
    for word in words:
        assert word in found[0]


def test_messages_arrive_whole_however_they_are_cut():
    reader = channel.Reader(10_000)
    payload = bytes(range(256))
    sent = b"".join(json.dumps({"stage": str(at), "bytes": at}).encode() + b"\n" + payload[:at] for at in (0, 7, 256))
    found = [message for at in range(0, len(sent), 5) for message in reader.feed(sent[at : at + 5])]
    assert [(header["stage"], body) for header, body in found] == [("0", b""), ("7", payload[:7]), ("256", payload)]


@pytest.mark.parametrize(
    "data",
    [
        b"x" * 70_000,
        b"[]\n",
        b"{}\n",
        b'{"bytes": -1}\n',
        b'{"bytes": 1e9}\n',
        b'{"bytes": true}\n',
        b"[" * 60_000 + b"\n",
    ],
)
def test_what_is_no_message_is_refused(data):
    with pytest.raises(channel.BrokenMessageError):
        list(channel.Reader(100_000).feed(data))
    with pytest.raises(channel.BrokenMessageError):
        list(channel.Reader(10).feed(b"x" * 11))


@pytest.mark.parametrize("lengths", [None, np.array([3, 5, 3, 3, 5, 9, 3])])
def test_every_sample_is_in_one_batch_with_others_of_its_length(lengths):
    order = np.random.default_rng(0).permutation(7)
    made = plan.batches(order, lengths, 3)
    assert sorted(sample for batch in made for sample in batch) == list(range(7))
    assert max(map(len, made)) <= 3
    if lengths is not None:
        assert all(len({lengths[sample] for sample in batch}) == 1 for batch in made)


def test_the_second_pass_has_another_order_and_company():
    rng = np.random.default_rng(1)
    again = plan.again(500, None, rng)
    assert len({sample for batch in again for sample in batch}) == plan.AGAIN
    assert again[0] != sorted(again[0])
    long = np.full(500, 60_000)
    assert len(plan.again(500, long, rng)) <= 2


def answer(scores, recheck, timed):
    latency = Latency(batch=1, calls=1, min_ms=1, p50_ms=1, p95_ms=1)
    return Answer(scores=scores, recheck=recheck, timed={1: timed}, latency=(latency,))


JOB = Job(batches=[[0, 1], [2]], recheck=[[2, 0]], timing=[{"batch": 1, "batches": [[1]]}], width=2, rows=6)
GIVEN = np.float32([[0, 1], [2, 3], [4, 5]])


def test_equal_scores_raise_no_doubt_and_come_by_sample():
    judged = judge(answer(GIVEN, GIVEN[[2, 0]], GIVEN[[1]]), JOB, None)
    assert (judged.reason, judged.doubts) == ("", ())
    np.testing.assert_array_equal(np.concatenate(judged.scores), GIVEN)


def test_scores_that_change_are_doubted_by_what_changed_them():
    moved = GIVEN + 0.1
    assert "order or company" in judge(answer(GIVEN, moved[[2, 0]], GIVEN[[1]]), JOB, None).doubts[0]
    assert "timed" in judge(answer(GIVEN, GIVEN[[2, 0]], moved[[1]]), JOB, None).doubts[0]
    rounding = GIVEN * np.float32(1 + 1e-6)
    assert not judge(answer(GIVEN, rounding[[2, 0]], rounding[[1]]), JOB, None).doubts


def test_scores_missing_or_not_finite_are_none():
    assert "2 of 3 scores" in judge(answer(GIVEN[:2], GIVEN[[2, 0]], GIVEN[[1]]), JOB, None).reason
    late = GIVEN.copy()
    late[2, 1] = np.inf
    assert "1 of 3 samples" in judge(answer(late, late[[2, 0]], late[[1]]), JOB, None).reason


def test_scores_in_time_are_cut_by_the_lengths_of_the_trials():
    job = Job(batches=[[1], [0]], recheck=[[1]], timing=[{"batch": 1, "batches": [[0]]}], width=0, rows=7)
    values = np.float32([[1], [2], [3], [4], [5]])
    judged = judge(answer(values, values[:3], values[3:]), job, np.array([2, 3]))
    assert [part.ravel().tolist() for part in judged.scores] == [[4, 5], [1, 2, 3]]
    assert not judged.doubts


def test_a_seed_is_committed_to_by_a_hash_that_does_not_tell_it():
    first = hidden.commitment(10**15, "fvsight-press")
    assert first == hidden.commitment(10**15, "fvsight-press")
    assert first != hidden.commitment(10**15 + 1, "fvsight-press")
    assert first != hidden.commitment(10**15, "fvsight-press/hard")
    drawn = {hidden.parse_seed("new") for _ in range(20)}
    assert len(drawn) == 20
    assert min(drawn) >= hidden.GUESSABLE
    for text in ("999", "-5", "x", str(2**63), ""):
        with pytest.raises(ValueError, match="hidden-seed"):
            hidden.parse_seed(text)


def test_hidden_presses_lie_on_sensors_that_no_suite_has(monkeypatch):
    seen = []
    monkeypatch.setattr("sensors.press.simulate", lambda scene, index, seed, truth: seen.append(index))
    hidden.ShiftedPresses(2_000_000)("scene", 3, 1)
    assert seen == [2_000_003]
    from vtbench.config import load_scene

    for scenes in hidden.SCENES.values():
        for name, overrides in scenes.values():
            assert load_scene(name, overrides).n_samples > 0


@pytest.mark.slow
def test_a_hidden_set_is_new_kept_private_and_tells_no_sensor(tmp_path, monkeypatch):
    from vtbench.onnx_eval.tested import on_hidden
    from vtbench.tasks import TASKS

    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path))
    task = TASKS.get("objects/interference/v1")
    made = hidden.make(task, "paper", 123_456, 27, 1)
    again = hidden.make(task, "paper", 123_456, 27, 1)
    assert again == made
    assert made.path.parent.stat().st_mode & 0o077 == 0
    tested = on_hidden(task.id, "paper", None, made)
    assert tested.hidden == made.commitment
    assert tested.split.name == "hidden"
    assert tested.data.ids.tolist() == [f"{at:06d}" for at in range(27)]
    assert set(tested.data.factors["unit"].tolist()) == {0}
    from vtbench.data import Dataset

    units = Dataset.open(made.path).columns(["unit"])["unit"]
    assert units.min() >= 6 * 1000
