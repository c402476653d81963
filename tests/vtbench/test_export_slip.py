"""Slip detectors as files: the detector and threshold of a run, whole sequences or one sample at a time."""

import json

import numpy as np
import onnxruntime
import pytest

import slip
import vtbench.exporting.detectors as detectors
from tests.vtbench.data import fake_slides
from vtbench.data.slide_writer import write_slides
from vtbench.run.detection.detect import DetectionWork, detect
from vtbench.tasks import TASKS
from vtbench.tasks.slides import load_slides

TASK = "slip/fvsight/v1"
LEARNT = [pytest.param("neural-force", "batch", marks=pytest.mark.slow)]


@pytest.fixture(scope="module")
def trials(tmp_path_factory):
    scene = fake_slides.FakeSlipScene(n_samples=6)
    return write_slides(tmp_path_factory.mktemp("slides") / "set", scene, simulate=fake_slides.simulate, progress=False)


@pytest.fixture
def export(vtbench, trials, tmp_path):
    def call(method, *more):
        return vtbench("export", TASK, method, "--data", trials, "-o", tmp_path / "made.onnx", "--json", *more)

    call.path = tmp_path / "made.onnx"
    return call


@pytest.mark.parametrize(
    ("method", "kind"), [("covariance", "batch"), ("energy-load-removed", "stream"), ("spectral", "batch"), *LEARNT]
)
def test_the_file_is_the_detector_of_a_run_with_its_threshold(export, trials, method, kind):
    answer = export(method, *(["--stream"] if kind == "stream" else []))
    assert answer.code == 0, answer.err
    (report,) = json.loads(answer.out)["exported"]
    task, data = TASKS.get(TASK), load_slides((trials,))
    split = task.variants["paper"].splits["random"](data, 0)
    found = detect(DetectionWork("", method, "prior", split, "", data, task, 60.0)).predictions
    beta = report["threshold"]["alarm_at_or_above"]
    assert beta == pytest.approx(found["beta"][0])
    test = split.folds[0].test
    assert report["parity"]["trials"] == len(test)
    assert report["parity"]["agreement"] == 1.0
    assert report["parity"]["nan_samples"]
    graph = (slip.OnnxStream if kind == "stream" else slip.OnnxBatch)(export.path)
    called = {trial: bool((graph.score(force) >= beta).any()) for trial, force in data.each_force(test)}
    assert all(called.values())  # every one of these trials slips
    if method != "neural-force":  # which has learnt from four trials
        assert all(graph.score(force)[60:900].max() < beta for _, force in data.each_force(test))
    stored = json.loads(onnxruntime.InferenceSession(export.path).get_modelmeta().custom_metadata_map["vtbench"])
    assert stored == {name: value for name, value in report.items() if name not in ("path", "bytes")}
    assert stored["kind"] == kind
    assert graph.metadata["settling"] == stored["settling"]  # what `slip` wrote stands beside it


def test_a_graph_of_another_detector_is_not_written(export, monkeypatch):
    honest = slip.export_onnx

    def other(detector, *arguments, **named):
        return honest(slip.make_detector("energy", window=7), *arguments, **named)

    monkeypatch.setattr(slip, "export_onnx", other)
    answer = export("energy")
    assert answer.code == 1
    assert "nothing was written" in json.loads(answer.out)["not_exported"][0]["reason"]
    assert not export.path.exists()


def test_nan_must_spoil_its_windows_and_nothing_else():
    class Graph:
        def __init__(self, told):
            self.told = told

        def score(self, force):
            bad = np.flatnonzero(~np.isfinite(force).all(1))
            scores = np.ones(len(force))
            for at in bad:
                scores[at : at + self.told] = np.nan
            return scores

    force = np.ones((200, 3), np.float32)
    assert detectors._answers_nan(Graph(11), force, {}, 11)
    assert not detectors._answers_nan(Graph(10), force, {}, 11)
    assert not detectors._answers_nan(Graph(200), force, {}, 11)


def test_all_goes_on_with_what_is_missing_and_keeps_what_was_made_by_the_same_order(
    vtbench, trials, tmp_path, monkeypatch
):
    chosen = ("energy", "spectral", "neural-force-frames")
    monkeypatch.setattr(detectors.DETECTORS, "ids", lambda: chosen)
    words = ("export", TASK, "--all", "--data", trials, "-o", tmp_path / "made")
    first = vtbench(*words)
    assert first.code == 1  # these trials have no frames
    assert "neural-force-frames: nothing to learn slip from" in first.out or "without frames" in first.out
    assert {path.name for path in (tmp_path / "made").iterdir()} == {f"prior-{name}-batch.onnx" for name in chosen[:2]}
    (tmp_path / "made" / "prior-energy-batch.onnx").write_bytes(b"cut off")
    fitted = []
    honest = detectors.fit
    monkeypatch.setattr(detectors, "fit", lambda name, *rest: fitted.append(name) or honest(name, *rest))
    again = vtbench(*words)
    assert fitted == ["energy", "neural-force-frames"]
    assert "1 of 3 were made before" in again.out
    assert again.out.count("energy") == first.out.count("energy")
    fitted.clear()
    vtbench(*words, "--seed", "1")
    assert fitted == list(chosen)
    fitted.clear()
    vtbench(*words, "--seed", "1", "--fresh")
    assert fitted == list(chosen)


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ((TASK, "energie"), "did you mean 'energy'"),
        ((TASK, "energy", "--modality", "pryor"), "did you mean 'prior'"),
        ((TASK, "energy", "--backbone", "pixels"), "takes no --backbone"),
        ((TASK, "energy", "--split", "nothing"), "unknown split"),
        ((TASK, "energy", "--fresh"), "a single file is always made again"),
        (("objects/deep/v1", "svm", "--stream"), "no detector that takes one sample"),
    ],
)
def test_bad_orders_are_refused_in_one_line(refused, trials, tmp_path, words, line):
    assert line in refused("export", *words, "--data", trials, "-o", tmp_path / "a.onnx")
    assert not list(tmp_path.glob("a.*"))


def test_trials_must_be_named(refused, tmp_path):
    assert "--data DIR" in refused("export", TASK, "energy", "-o", tmp_path / "a.onnx")
