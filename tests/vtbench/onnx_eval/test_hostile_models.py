"""Twelve that are careless or hostile: each is answered in words, none stops the others, none writes elsewhere."""

import os
import tempfile
from pathlib import Path

import pytest

from leaderboard.record import read_records
from tests.vtbench.onnx_eval import graphs
from vtbench.onnx_eval.sandbox import Limits

BIG = 2**28
"""Numbers of a gigabyte."""


def files_outside(*roots):
    return {path for root in roots for path in Path(root).rglob("*")}


@pytest.fixture(autouse=True)
def nothing_is_left_elsewhere(tmp_path, monkeypatch):
    """No case leaves a file but its record: not in the temporary folder, not beside the model, not where we stand."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(elsewhere))
    monkeypatch.chdir(elsewhere)
    yield
    assert not list(elsewhere.iterdir())
    made = {path.name for path in tmp_path.iterdir() if path.suffix != ".onnx"}
    assert made <= {"elsewhere", "out"}
    assert {path.name for path in (tmp_path / "out").rglob("*") if path.is_file()} <= {"record.json", "predictions.npz"}


def refused(record, *words, state="failed"):
    assert record.status.state == state
    assert "\n" not in record.status.reason
    for word in words:
        assert word in record.status.reason, record.status.reason
    assert not record.metrics
    return record


@pytest.mark.slow
def test_an_endless_loop_ends_at_the_time_limit(judged, tmp_path):
    record = judged(graphs.endless(tmp_path / "endless.onnx"), time_s=2.0)
    refused(record, "took longer than 2 s", "--time-limit", "predicting", state="timeout")


@pytest.mark.slow
def test_a_memory_bomb_meets_the_memory_limit(judged, tmp_path):
    refused(judged(graphs.bomb(tmp_path / "bomb.onnx", 8 * BIG), memory_mb=512), "512 MB", "--memory-limit")


@pytest.mark.slow
def test_three_gigabytes_of_output_never_reach_us(judged, tmp_path):
    wide = graphs.huge_output(tmp_path / "wide.onnx", 3 * BIG // 32)
    refused(judged(wide, memory_mb=1024), "1024 MB", "--memory-limit")
    refused(judged(graphs.huge_output(tmp_path / "w.onnx", 4000), memory_mb=1024), "(32, 4000)", "expected (32, 4)")


def test_wrong_names_are_named_with_the_right_ones(judged, tmp_path):
    inputs = [graphs.value("forces", graphs.F, ["N", 16])]
    nodes = [graphs.node("ReduceSum", ["forces"], ["logits"])]
    model = graphs.save(tmp_path / "names.onnx", nodes, inputs, [graphs.value("logits", graphs.F, ["N", 4])])
    refused(judged(model), "'forces'", "rename it to 'force'", "'scores' is missing", "'logits'")


def test_wrong_shapes_are_told_by_axis_or_when_they_come(judged, tmp_path):
    fixed = graphs.linear(tmp_path / "fixed.onnx", inputs=[graphs.value("force", graphs.F, [1, 12])])
    refused(judged(fixed), "axis 0 (N) to be free, found 1", "expected 16 on axis 1, found 12")
    refused(judged(graphs.transposed(tmp_path / "turned.onnx")), "shape (4, 32)", "expected (32, 4)")


def test_scores_that_are_not_numbers_are_counted_and_refused(judged, tmp_path, known):
    bad = int((known[0] < 1.0).any(1).sum())
    assert bad > 0
    refused(judged(graphs.not_a_number(tmp_path / "nan.onnx")), f"{bad} of {len(known[0])} samples", "not finite")


def test_a_custom_operator_is_refused_wherever_it_hides(judged, tmp_path):
    refused(judged(graphs.custom(tmp_path / "custom.onnx")), "com.example.Rob", "custom operators")
    branch = graphs.helper.make_graph(
        [graphs.node("Rob", ["force"], ["inner"], domain="com.example")], "b", [], [graphs.value("inner", 1, None)]
    )
    deep = graphs.node("If", ["true"], ["scores"], then_branch=branch, else_branch=branch)
    yes = graphs.constant("true", graphs.np.bool_(True))
    hidden = graphs.save(tmp_path / "branch.onnx", [deep], constants=[yes], domains=["com.example"])
    refused(judged(hidden), "com.example.Rob")
    body = [graphs.node("Rob", ["x"], ["y"], domain="com.example")]
    opsets = [graphs.helper.make_opsetid("com.example", 1)]
    function = graphs.helper.make_function("mine", "Wrapped", ["x"], ["y"], body, opsets)
    call = [graphs.node("Wrapped", ["force"], ["scores"], domain="mine")]
    wrapped = graphs.save(tmp_path / "function.onnx", call, domains=["mine", "com.example"], functions=[function])
    refused(judged(wrapped), "com.example.Rob")


@pytest.mark.parametrize("location", ["../../etc/passwd", "/etc/passwd", "weights.bin", "<b>\x1b[31m"])
def test_data_outside_the_file_are_never_opened(judged, tmp_path, location):
    record = refused(judged(graphs.outside(tmp_path / "outside.onnx", location)), "lies outside the file", "'w'")
    assert record.status.reason.isprintable()


def test_a_truncated_file_is_no_model(judged, honest):
    honest.write_bytes(honest.read_bytes()[:-40])
    refused(judged(honest), "no ONNX model", "truncated")
    honest.write_bytes(b"")
    refused(judged(honest), "no ONNX model")


def test_labels_do_not_leak_by_the_order_of_samples(judged, tmp_path, known):
    labels = known[1]
    assert (labels == [place % graphs.CLASSES for place in range(len(labels))]).all()  # the attack would be perfect
    record = judged(graphs.by_place(tmp_path / "place.onnx"))
    assert record.status.state == "ok"
    assert record.metrics[0].value < 0.65
    assert record.submission.status == "flagged"
    assert "order or company" in record.submission.reason


def test_scores_that_lean_on_the_other_samples_are_flagged(judged, tmp_path, known):
    record = judged(graphs.by_company(tmp_path / "company.onnx", *known))
    assert record.submission.status == "flagged"
    assert "order or company" in record.submission.reason


def test_the_good_are_scored_beside_all_of_them(judged, tmp_path, honest):
    broken = judged(graphs.custom(tmp_path / "custom.onnx"))
    good = judged(honest)
    assert {record.key: record.status.state for record in read_records(tmp_path / "out")} == {
        broken.key: "failed",
        good.key: "ok",
    }


def test_a_process_that_says_too_much_is_ended(tmp_path, monkeypatch, tested, honest):
    from vtbench.onnx_eval import sandbox
    from vtbench.onnx_eval.offers import offer_of

    offer = offer_of(tested.task, tested.paths, tested.data)
    shouting = "import os\nwhile True: os.write(3, b'x' * 100000)"
    monkeypatch.setattr(sandbox, "_PROGRAM", f"exec({shouting!r})")
    with sandbox.private_folder(honest.read_bytes()) as folder:
        answer = sandbox.run(folder, offer.contract, sandbox.Job(), Limits(20.0))
    assert answer.state == "failed"
    assert answer.reason.startswith("stopped: it sent")
    lying = """import os; os.write(3, b'{"stage": "done", "parameters": -1, "bytes": 0}\\n')"""
    monkeypatch.setattr(sandbox, "_PROGRAM", lying)
    with sandbox.private_folder(honest.read_bytes()) as folder:
        answer = sandbox.run(folder, offer.contract, sandbox.Job(), Limits(20.0))
    assert "not agreed" in answer.reason


def test_the_locked_process_opens_writes_and_reaches_nothing(tmp_path):
    """Code that had broken out would find the doors shut; each lock that the kernel refused is named instead."""
    import subprocess
    import sys

    program = f"""
import os, socket, json
from vtbench.onnx_eval import protect
held = protect.isolate()
def tried(what):
    try:
        what()
    except (OSError, MemoryError) as error:
        return type(error).__name__
    return "done"
tries = {{
    "writing": tried(lambda: open({str(tmp_path / "new")!r}, "w").write("x")),
    "network": tried(lambda: socket.create_connection(("192.0.2.1", 80), 1)),
}}
held |= protect.limit(256, 5)
held |= protect.close_files()
tries |= {{
    "reading": tried(lambda: open("/etc/hostname").read()),
    "memory": tried(lambda: bytearray(2**30)),
}}
print(json.dumps([held, tries]))
"""
    import json

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=dict(os.environ))
    held, tried = json.loads(done.stdout)
    for lock in ("writing", "reading", "network", "memory"):
        assert (held[lock] == "held") <= (tried[lock] != "done"), (held, tried)
        assert held[lock] == "held" or held[lock].startswith("not held: ")
    assert not list(tmp_path.glob("new"))
