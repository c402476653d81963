"""An honest model is scored as it would be by hand, at once and in any order, and its record says what it cost."""

import numpy as np
import pytest

from leaderboard.record import read_predictions, read_records
from tests.vtbench.data import fake_slides
from tests.vtbench.onnx_eval import graphs
from tests.vtbench.run import small
from vtbench.cli import main
from vtbench.data.slide_writer import write_slides
from vtbench.onnx_eval.evaluate import evaluate
from vtbench.onnx_eval.handed_in import Credit
from vtbench.onnx_eval.sandbox import Limits
from vtbench.onnx_eval.tested import on_datasets
from vtbench.run import rescore, run_suite

CREDIT = Credit("someone", "Someone's")


def by_hand(force, labels):
    means = np.stack([force[labels == label].mean(0) for label in range(graphs.CLASSES)])
    return ((force[:, None] - means) ** 2).sum(2).argmin(1)


@pytest.fixture(scope="module")
def evaluated(presses, known, tested, tmp_path_factory):
    """One evaluation of the honest model: its record, the folder, the model."""
    root = tmp_path_factory.mktemp("honest")
    model = graphs.honest(root / "honest.onnx", *known)
    return evaluate(model, tested, CREDIT, root / "out", Limits(60.0, 1024)), root / "out", model


def test_predictions_are_those_of_the_model_in_the_order_of_the_data(evaluated, known, tested):
    record, out, _ = evaluated
    kept = read_predictions(out, record.key)
    force, labels = known
    assert (kept["sample_id"] == tested.data.ids).all()
    assert (kept["label"] == by_hand(force, labels)).all()
    assert record.metrics[0].value == pytest.approx((by_hand(force, labels) == labels).mean())
    assert kept["scores"].shape == (len(labels), graphs.CLASSES)


def test_the_record_says_whose_it_is_and_what_it_cost(evaluated):
    record, out, model = evaluated
    submission = record.submission
    assert (submission.status, submission.reason, record.identity.modality) == ("verified", "", "force")
    artifact = submission.artifact
    assert artifact.size_bytes == model.stat().st_size
    assert artifact.parameters == graphs.TAXELS * graphs.CLASSES + graphs.CLASSES
    assert [latency.batch for latency in artifact.latency] == [1, 100]
    for latency in artifact.latency:
        assert 0 < latency.min_ms <= latency.p50_ms <= latency.p95_ms
    assert artifact.latency[0].first_ms >= 0
    assert 20 < artifact.peak_rss_mb < 1000
    assert record.identity.params["artifact"] == artifact.sha256
    assert {"memory", "processor time", "file size", "network", "reading", "writing"} <= set(artifact.protections)
    assert read_records(out) == [record]


def test_the_same_file_is_the_same_record_and_under_another_id_flagged(evaluated, tested, known, tmp_path):
    record, _, model = evaluated
    again = evaluate(model, tested, CREDIT, tmp_path / "out")
    assert again.key == record.key
    assert again.metrics == record.metrics  # whatever the order in which the model met the samples
    copy = evaluate(model, tested, Credit("copycat", "Mine"), tmp_path / "out")
    assert copy.submission.status == "flagged"
    assert "someone" in copy.submission.reason
    other = graphs.honest(tmp_path / "other.onnx", known[0] + 1, known[1])
    assert evaluate(other, tested, CREDIT, tmp_path / "out").key != record.key


def test_only_the_test_parts_of_a_split_are_seen_and_scored(presses, evaluated, tmp_path):
    split = on_datasets("objects/interference/v1", "own", "held-out-unit", [presses], fold="unit-1")
    record = evaluate(evaluated[2], split, CREDIT, tmp_path / "out")
    assert record.identity.split == "held-out-unit"
    assert record.metrics[0].n == 16
    assert set(read_predictions(tmp_path / "out", record.key)["group"]) == {"1"}


@pytest.mark.slow
def test_a_run_keeps_the_records_of_others_and_does_not_score_them_again(presses, evaluated, tested, tmp_path):
    suite = small.suite(presses)
    run_suite(suite, tmp_path / "run", progress=False)
    record = evaluate(evaluated[2], tested, CREDIT, tmp_path / "run")
    assert run_suite(suite, tmp_path / "run", progress=False).done == 0
    rescore(tmp_path / "run")
    assert record in read_records(tmp_path / "run")


def test_a_file_too_large_is_refused_unread(tested, tmp_path, monkeypatch):
    monkeypatch.setattr("vtbench.onnx_eval.evaluate.LARGEST_MODEL_MB", 2)
    model = tmp_path / "large.onnx"
    with model.open("wb") as file:
        file.truncate(3 * 2**20)
    record = evaluate(model, tested, CREDIT, tmp_path / "out")
    assert record.status.state == "failed"
    assert "a file of 3 MB: expected 2" in record.status.reason


def test_frames_and_forces_in_time_reach_the_model_whole(presses, tested, tmp_path):
    """A model whose scores are sums over all that it is fed, against the same sums by hand."""
    from vtbench.data import Dataset

    node, value = graphs.node, graphs.value
    inputs = [
        value("image", 2, ["N", 24, 24, 3]),
        value("image_rest", 2, ["N", None, None, 3]),
        value("force_series", graphs.F, ["N", "T", 16]),
    ]
    nodes = []
    for name, axes in (("image", [1, 2, 3]), ("image_rest", [1, 2, 3]), ("force_series", [1, 2])):
        nodes += [
            node("Cast", [name], [f"{name}_f"], to=graphs.F),
            node("ReduceMean", [f"{name}_f"], [f"{name}_sum"], axes=axes, keepdims=0),
            node("Unsqueeze", [f"{name}_sum", "last"], [f"{name}_column"]),
        ]
    nodes.append(node("Concat", [f"{each.name}_column" for each in inputs], ["three"], axis=1))
    nodes.append(node("Pad", ["three", "pads"], ["scores"]))
    numbers = [graphs.constant("last", np.int64([1])), graphs.constant("pads", np.int64([0, 0, 0, 1]))]
    model = graphs.save(tmp_path / "all.onnx", nodes, inputs, constants=numbers)
    record = evaluate(model, tested, CREDIT, tmp_path / "out")
    assert record.status.reason == ""
    assert record.identity.modality == "force-series-image"
    assert record.submission.status == "verified"
    dataset = Dataset.open(presses)
    expected = np.stack(
        [
            dataset.images().mean((1, 2, 3)),
            dataset.images(column="image_rest").mean((1, 2, 3)),
            [series.mean() for series in dataset.force_series()],
        ],
        axis=1,
    )
    found = read_predictions(tmp_path / "out", record.key)["scores"]
    np.testing.assert_allclose(found[:, :3], expected, rtol=1e-4)


def covariance_in_both_ways(tested, tmp_path):
    """Metrics at a rate of false alarms of the exported graph and of the detector in the grid; no threshold in them."""
    import slip
    from vtbench.run.detection.detect import DetectionWork, detect
    from vtbench.run.detection.scoring import score_slips

    detector = slip.make_detector("covariance", window=tested.task.window)
    slip.export_onnx(detector, tmp_path / "covariance.onnx")
    record = evaluate(tmp_path / "covariance.onnx", tested, CREDIT, tmp_path / "out")
    work = DetectionWork("", "covariance", "prior", tested.split, "", tested.data, tested.task, 60.0)
    ours = {m.name: m.value for m in score_slips(detect(work).predictions, tested.data, tested.task)}
    return {m.name: (m.value, ours[m.name]) for m in record.metrics if "@" in m.name or m.name == "roc_area"}


@pytest.mark.slow
def test_slip_scores_are_held_to_the_events_of_the_trials(tmp_path):
    scene = fake_slides.FakeSlipScene(n_samples=12)
    folder = write_slides(tmp_path / "slides", scene, simulate=fake_slides.simulate, progress=False)
    tested = on_datasets("slip/fvsight/v1", None, "held-out-object", [folder])
    record = evaluate(graphs.differences(tmp_path / "slip.onnx"), tested, CREDIT, tmp_path / "out")
    assert record.status.reason == ""
    metrics = {metric.name: metric.value for metric in record.metrics}
    assert metrics["detected"] == 1.0
    assert metrics["delay_ms"] < 100
    assert "stream_us" not in metrics
    parity = covariance_in_both_ways(tested, tmp_path)
    assert len(parity) > 6
    for name, (theirs, ours) in parity.items():
        assert theirs == pytest.approx(ours, rel=1e-4), name
    constant = graphs.save(
        tmp_path / "constant.onnx",
        [
            graphs.node("ReduceSum", ["force_series", "axis"], ["sum"], keepdims=0),
            graphs.node("Mul", ["sum", "zero"], ["slip_score"]),
        ],
        [graphs.value("force_series", graphs.F, ["N", "T", 16])],
        [graphs.value("slip_score", graphs.F, ["N", "T"])],
        [graphs.constant("axis", np.int64([2])), graphs.constant("zero", np.float32(0))],
    )
    refused = evaluate(constant, tested, CREDIT, tmp_path / "out")
    assert refused.status.state == "failed"
    assert "beta cannot be found" in refused.status.reason


def test_the_command_ends_with_one_for_a_failed_model_and_two_for_bad_input(presses, honest, tmp_path, capsys):
    line = ["evaluate", str(honest), "--task", "objects/interference/v1", "--variant", "own", "--data", str(presses)]
    assert main([*line, "-o", str(tmp_path / "out"), "--name", "Nearest mean"]) == 0
    told = capsys.readouterr().out
    assert "accuracy" in told
    assert "SHA-256" in told
    honest.write_bytes(b"nothing")
    assert main([*line, "-o", str(tmp_path / "out")]) == 1
    assert "no ONNX model" in capsys.readouterr().out
    bad = {
        "--name": "<script>alert(1)</script>",
        "--split": "randm",
        "--fold": "run-0",
        "--hidden-seed": "7",
        "--samples": "10",
        "--variant": "papr",
        "--time-limit": "-1",
    }
    for option, value in bad.items():
        assert main([*line, "-o", str(tmp_path / "out"), option, value]) == 2
        told = capsys.readouterr()
        assert told.err.count("\n") == 1
        assert not told.out
    assert main(["evaluate", str(honest), "-o", str(tmp_path / "out")]) == 2
    assert "--task" in capsys.readouterr().err
