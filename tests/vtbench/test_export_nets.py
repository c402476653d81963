"""Fusion nets as files, from raw frames and force histories: the labels of a run, whatever the length of a history."""

import json

import numpy as np
import onnxruntime
import pytest

from tests.vtbench.run import small
from vtbench.data import Dataset
from vtbench.run.evaluate import evaluate
from vtbench.run.features import DiskFeatures
from vtbench.run.methods import METHODS
from vtbench.tasks import TASKS

TASK = "objects/interference/v1"


@pytest.fixture(scope="module")
def presses(tmp_path_factory):
    return small.write(tmp_path_factory.mktemp("presses") / "set")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "modality"),
    [
        ("late-fusion", "force-series"),
        ("fusion-transformer", "fused-pixels-change"),
    ],
)
def test_a_net_answers_from_raw_recordings_what_a_run_answered(vtbench, presses, tmp_path, method, modality):
    path = tmp_path / "net.onnx"
    words = ("--modality", modality, "--data", presses, "--variant", "own", "-o", path, "--json")
    answer = vtbench("export", TASK, method, *words)
    assert answer.code == 0, answer.err
    (report,) = json.loads(answer.out)["exported"]
    assert report["parity"]["agreement"] == 1.0
    assert report["parity"]["nan_rows"]
    task = TASKS.get(TASK)
    data = task.load(presses, DiskFeatures(tmp_path / "features"), "pixels")
    feed, split = task.modalities[modality], task.variants["own"].splits["random"](data, 0)
    cell = small.work(
        METHODS.get(method),
        feed,
        blocks={block.name: data.block(block.name) for block in feed.blocks},
        labels=data.labels,
        folds=split.folds[:1],
        n_classes=len(data.classes),
        samples_name=f"net {modality}",
    )
    expected = evaluate(cell).predictions["label"]
    session = onnxruntime.InferenceSession(path)
    dataset, rows = Dataset.open(presses), split.folds[0].test
    raw = {
        "image": lambda: list(dataset.images(rows)),
        "image_rest": lambda: list(dataset.images(rows, column="image_rest")),
        "force_series": lambda: [np.asarray(each, np.float32) for each in dataset.force_series(rows)],
    }
    inputs = {each.name: raw[each.name]() for each in session.get_inputs()}
    assert set(inputs) == ({"force_series"} if modality == "force-series" else set(raw))
    found = [
        session.run(["scores"], {name: each[at][None] for name, each in inputs.items()}) for at in range(len(rows))
    ]
    np.testing.assert_array_equal(np.concatenate([scores for (scores,) in found]).argmax(1), expected)
