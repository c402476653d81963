"""Pipelines as files: what a run fits, in a plain session; refusals in one line; nothing that does not agree."""

import json

import numpy as np
import onnx
import onnxruntime
import pytest

import vtbench.exporting.parity
from tests.vtbench.run import small
from vtbench.data import Dataset
from vtbench.run.evaluate import evaluate
from vtbench.run.features import DiskFeatures
from vtbench.run.methods import METHODS
from vtbench.tasks import TASKS

TASK = "objects/interference/v1"
MODALITIES = ("force", "image", "image-change", "fused", "fused-equal", "fused-change")
METHOD_IDS = ("ksc", "jksc", "jksc-independent", "knn", "wknn", "svm", "ipca-wknn")
CELLS = [
    (method, modality)
    for modality in MODALITIES
    for method in METHOD_IDS
    if "fused" in modality or not METHODS.get(method).joint
]
QUICK = {("svm", "force"), ("knn", "image-change"), ("wknn", "fused"), ("jksc", "fused")}


@pytest.fixture(scope="module")
def presses(tmp_path_factory):
    return small.write(tmp_path_factory.mktemp("presses") / "set")


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    return tmp_path_factory.mktemp("features")


@pytest.fixture
def export(vtbench, presses, kept, tmp_path):
    def call(method, modality, *more, task=TASK):
        words = ("--modality", modality, "--data", presses, "--variant", "own", "--backbone", "pixels")
        return vtbench("export", task, method, *words, "--features", kept, "-o", tmp_path / "made.onnx", *more)

    call.path = tmp_path / "made.onnx"
    return call


def inputs_of(dataset, names, rows):
    read = {
        "image": lambda: dataset.images(rows),
        "image_rest": lambda: dataset.images(rows, column="image_rest"),
        "force": lambda: dataset.force(rows),
    }
    return {name: read[name]() for name in names}


@pytest.mark.parametrize(
    ("method", "modality"),
    [pytest.param(*cell, marks=() if cell in QUICK else pytest.mark.slow) for cell in CELLS],
)
def test_the_file_answers_what_a_run_answered_on_the_test_part(export, presses, kept, method, modality):
    answer = export(method, modality, "--json")
    assert answer.code == 0, answer.err
    model = onnx.load(export.path)
    onnx.checker.check_model(model, full_check=True)
    assert {node.domain for node in model.graph.node} == {""}
    session = onnxruntime.InferenceSession(export.path)
    names = {each.name for each in session.get_inputs()}
    wanted = {"force"} if modality == "force" else {"image"} | ({"force"} if "fused" in modality else set())
    assert names == wanted | ({"image_rest"} if "change" in modality else set())

    task = TASKS.get(TASK)
    data = task.load(presses, DiskFeatures(kept), "pixels")
    feed, split = task.modalities[modality], task.variants["own"].splits["random"](data, 0)
    cell = small.work(
        METHODS.get(method),
        feed,
        blocks={block.name: data.block(block.name) for block in feed.blocks},
        labels=data.labels,
        folds=split.folds[:1],
        n_classes=len(data.classes),
        samples_name=f"export {modality}",
    )
    expected = evaluate(cell).predictions["label"]
    inputs = inputs_of(Dataset.open(presses), names, split.folds[0].test)
    scores = session.run(["scores"], inputs)[0]
    assert scores.shape == (len(expected), small.CLASSES)
    np.testing.assert_array_equal(scores.argmax(axis=1), expected)
    if "force" in inputs:
        inputs["force"][1, 3] = np.nan
        spoiled = session.run(["scores"], inputs)[0]
        assert np.isnan(spoiled[1]).all()
        np.testing.assert_allclose(np.delete(spoiled, 1, axis=0), np.delete(scores, 1, axis=0), rtol=1e-5, atol=1e-6)


def test_the_report_is_printed_and_stands_in_the_file(export, presses):
    printed = json.loads(export("knn", "force", "--json").out)
    (report,) = printed["exported"]
    stored = json.loads(onnxruntime.InferenceSession(export.path).get_modelmeta().custom_metadata_map["vtbench"])
    assert stored == {name: value for name, value in report.items() if name not in ("path", "bytes")}
    assert stored["classes"] == Dataset.open(presses).classes
    assert stored["dataset_hash"] == Dataset.open(presses).hash
    assert stored["fit"] == {"part": "train", "fold": "run-0", "samples": 36, "seed": 0}
    assert set(stored["choices"]) == {"sizes", "weights", "params"}
    assert stored["parity"]["samples"] == 12
    assert stored["parity"]["agreement"] == 1.0
    assert report["bytes"] == export.path.stat().st_size
    assert " 1.000 " in export("knn", "force").out


def test_a_graph_that_does_not_agree_is_not_written(export, monkeypatch):
    honest = vtbench.exporting.parity.reference

    def shifted(classifier, x):
        place, scores = honest(classifier, x)
        return (place + 1) % small.CLASSES, np.roll(scores, 1, axis=1)

    monkeypatch.setattr(vtbench.exporting.parity, "reference", shifted)
    answer = export("wknn", "force")
    assert answer.code == 1
    assert "nothing was written" in answer.out
    assert not export.path.exists()


def test_every_sample_may_be_fitted_and_the_file_says_so(export):
    (report,) = json.loads(export("knn", "force", "--fit", "all", "--json").out)["exported"]
    assert report["fit"] == {"part": "all", "fold": "all", "samples": small.N, "seed": 0}
    assert report["checked_on"] == "the samples it was fitted on"


@pytest.mark.parametrize(
    "name", ["discriminant_analysis:LinearDiscriminantAnalysis", "linear_model:LogisticRegression"]
)
def test_a_classifier_of_scikit_learn_is_held_to_its_probabilities(export, name):
    """It has a decision function too, which is not what skl2onnx writes."""
    (report,) = json.loads(export(f"sklearn.{name}", "force", "--json").out)["exported"]
    assert report["parity"]["agreement"] == 1.0
    assert report["parity"]["relative_difference"] < 1e-3


def test_all_writes_a_file_for_each_method_and_reports_what_it_could_not(vtbench, presses, kept, tmp_path):
    words = ("--data", presses, "--variant", "own", "--modality", "force", "--features", kept)
    answer = vtbench("export", TASK, "--all", *words, "-o", tmp_path / "made", "--json")
    names = {path.stem for path in (tmp_path / "made").glob("*.onnx")}
    assert {"force-ksc", "force-knn", "force-wknn", "force-svm", "force-ipca-wknn"} <= names
    told = json.loads(answer.out)
    assert len(told["exported"]) == len(names)
    assert answer.code == (1 if told["not_exported"] else 0)
    assert told["kept"] == 0
    again = json.loads(vtbench("export", TASK, "--all", *words, "-o", tmp_path / "made", "--json").out)
    assert again["exported"] == told["exported"]  # latencies too: nothing was made again
    assert again["kept"] == len(names)


def test_with_all_a_graph_that_breaks_costs_no_other(vtbench, presses, kept, tmp_path, monkeypatch):
    def broken(*_):
        raise RuntimeError("the converter gave up")

    monkeypatch.setattr("fusion.onnx.neighbors.weighted_neighbors", broken)
    words = ("--data", presses, "--variant", "own", "--modality", "force", "--features", kept)
    monkeypatch.setattr(METHODS, "items", lambda: [(name, METHODS.get(name)) for name in ("wknn", "knn")])
    answer = vtbench("export", TASK, "--all", *words, "-o", tmp_path / "made")
    assert answer.code == 1
    assert "not exported: force, wknn: RuntimeError: the converter gave up" in answer.out
    assert [path.name for path in (tmp_path / "made").iterdir()] == ["force-knn.onnx"]


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ((TASK, "ksk", "-o", "a.onnx"), "did you mean 'ksc'"),
        ((TASK, "jksc", "--modality", "force", "-o", "a.onnx"), "force is one; use ksc"),
        ((TASK, "ksc", "--modality", "sound", "-o", "a.onnx"), "unknown modality"),
        ((TASK, "ksc", "--variant", "papper", "-o", "a.onnx"), "did you mean 'paper'"),
        ((TASK, "ksc", "--backbone", "resnet", "-o", "a.onnx"), "unknown backbone"),
        ((TASK, "ksc", "-o", "a.pt"), "ends in .onnx"),
        ((TASK, "ksc", "-o", "nowhere/a.onnx"), "no folder nowhere"),
        ((TASK, "-o", "a.onnx"), "expected a METHOD, or --all"),
        ((TASK, "sklearn.linear_model:Lasso", "--modality", "force", "-o", "a.onnx"), "not a classifier"),
    ],
)
def test_bad_orders_are_refused_in_one_line(refused, presses, kept, tmp_path, monkeypatch, words, line):
    monkeypatch.chdir(tmp_path)
    variant = () if "--variant" in words else ("--variant", "own")
    assert line in refused("export", *words, "--data", presses, *variant, "--features", kept)
    assert not list(tmp_path.glob("a.*"))


@pytest.mark.parametrize("words", [("svmm",), ("svm", "--modality", "imag"), ("svm", "--backbone", "vt-vg")])
def test_a_misspelt_name_is_refused_before_anything_is_simulated(refused, monkeypatch, words):
    def simulated(*_, **__):
        raise AssertionError("it was simulated")

    monkeypatch.setattr("vtbench.data.opening.write_scene", simulated)
    assert "did you mean" in refused("export", TASK, *words, "-o", "a.onnx")
