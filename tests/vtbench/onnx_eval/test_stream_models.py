"""Graphs of one sample with states are run over whole sequences; what cannot be run is told in one line."""

import numpy as np
import pytest

import slip
from tests.vtbench.data import fake_slides
from vtbench.cli import main
from vtbench.data.slide_writer import write_slides
from vtbench.onnx_eval import inspect_graph, stream
from vtbench.onnx_eval.batches import OutputError
from vtbench.onnx_eval.contract import Contract, Port, breaches
from vtbench.onnx_eval.evaluate import evaluate
from vtbench.onnx_eval.handed_in import Credit
from vtbench.onnx_eval.tested import on_datasets
from vtbench.submissions.checking import general_contract
from vtbench.tasks import TASKS

SLIP = Contract((Port("force_series", "float32", ("N", 90, 4)),), Port("slip_score", "float32", ("N", 90)))
FORCE = Port("force", "float32", (1, 4))
STATE, BACK = Port("state_sum", "float64", (1, 2)), Port("state_sum_out", "float64", (1, 2))
SCORE = Port("slip_score", "float32", (1, 1))


def summing(names, fed):
    """Sum of the forces so far, in a state of two numbers: the sum, and how many samples it is of."""
    state = fed["state_sum"] + np.array([[fed["force"].sum(), 1.0]])
    given = {"slip_score": state[:, :1].astype(np.float32), "state_sum_out": state}
    return [given[name] for name in names]


def test_states_are_carried_on_within_a_sequence_and_fresh_for_the_next():
    force = np.random.default_rng(0).normal(size=(3, 20, 4)).astype(np.float32)
    scores = stream.over_sequences(summing, [FORCE, STATE])({"force_series": force})
    assert scores.dtype == np.float32
    np.testing.assert_allclose(scores, force.sum(2).cumsum(1), atol=1e-5)
    with pytest.raises(OutputError, match="expected float32"):
        stream.over_sequences(lambda names, fed: [np.zeros((1, 4)), fed["state_sum"]], [FORCE, STATE])(
            {"force_series": force}
        )


def test_a_graph_with_states_is_taken_by_slip_tasks_as_it_stands():
    assert stream.is_stream([FORCE, STATE])
    assert not stream.is_stream([FORCE])
    assert stream.breaches(SLIP, [FORCE, STATE], [SCORE, BACK]) == []
    assert stream.breaches(general_contract(TASKS.get("slip/hard/v1")), [FORCE, STATE], [SCORE, BACK]) == []


@pytest.mark.parametrize(
    ("inputs", "outputs", "said"),
    [
        ([STATE], [SCORE, BACK], "input 'force' (1, taxels) is missing"),
        ([Port("force", "float32", (1, 5)), STATE], [SCORE, BACK], "expected force (1, 4) float32"),
        ([Port("force", "float32", (None, 4)), STATE], [SCORE, BACK], "expected force (1, 4) float32"),
        ([FORCE, STATE], [BACK], "output 'slip_score'"),
        ([FORCE, STATE], [SCORE], "output 'state_sum_out'"),
        ([FORCE, STATE], [SCORE, Port("state_sum_out", "float32", (1, 2))], "output 'state_sum_out'"),
        ([FORCE, Port("state_sum", "float64", (None, 2))], [SCORE, BACK], "expected a fixed shape"),
        ([FORCE, Port("state_sum", "string", (1, 2))], [SCORE, BACK], "expected a fixed shape"),
        ([FORCE, STATE, Port("frame", "uint8", (1, 8, 8, 3))], [SCORE, BACK], "input 'frame'"),
        ([FORCE, Port("state_x", "float64", (2**13, 2**13))], [SCORE, Port("state_x_out", "float64", None)], "state_x"),
    ],
)
def test_what_cannot_be_run_over_a_sequence_is_one_line(inputs, outputs, said):
    (line,) = stream.breaches(SLIP, inputs, outputs)
    assert said in line


def test_states_that_would_fill_the_memory_are_refused():
    huge = Port("state_x", "float64", (2**13, 2**13))
    (line,) = stream.breaches(SLIP, [FORCE, huge], [SCORE, Port("state_x_out", "float64", (2**13, 2**13))])
    assert "more than" in line


def test_other_tasks_and_cameras_say_what_to_do():
    presses = general_contract(TASKS.get("objects/deep/v1"))
    (line,) = stream.breaches(presses, [FORCE, STATE], [SCORE, BACK])
    assert "export one without states" in line
    (line,) = breaches(SLIP, [SLIP.inputs[0], Port("frames", "uint8", ("N", "F", 8, 8, 3))], [SLIP.output])
    assert "export a detector of forces alone" in line


def test_the_command_checks_a_single_model(tmp_path, capsys):
    path = tmp_path / "energy.onnx"
    slip.export_onnx(slip.make_detector("energy"), path, "stream")
    graph, refused = inspect_graph.read(path.read_bytes())
    assert not refused
    assert stream.is_stream(graph.inputs)
    assert main(["check", str(path), "--task", "slip/fvsight/v1"]) == 0
    assert "ok (model for slip/fvsight/v1)" in capsys.readouterr().out
    assert main(["check", str(path), "--task", "objects/deep/v1"]) == 2
    assert "S008 a graph that carries states" in capsys.readouterr().err
    for words in ([str(path)], [str(tmp_path), "--task", "slip/fvsight/v1"], [str(tmp_path / "none.onnx")]):
        assert main(["check", *words]) == 2
        assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.slow
def test_a_stream_scores_as_the_graph_of_whole_sequences(tmp_path):
    scene = fake_slides.FakeSlipScene(n_samples=6)
    folder = write_slides(tmp_path / "slides", scene, simulate=fake_slides.simulate, progress=False)
    tested = on_datasets("slip/fvsight/v1", None, "held-out-object", [folder])
    found = {}
    for kind in ("batch", "stream"):
        slip.export_onnx(slip.make_detector("energy"), tmp_path / f"{kind}.onnx", kind)
        record = evaluate(tmp_path / f"{kind}.onnx", tested, Credit(kind, kind), tmp_path / "out")
        assert (record.status.reason, record.submission.status) == ("", "verified")
        found[kind] = {metric.name: metric.value for metric in record.metrics if not metric.name.endswith("_us")}
    assert found["stream"] == pytest.approx(found["batch"], nan_ok=True)
