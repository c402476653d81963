"""The network, its graph, its training and its evidence."""

import json

import numpy as np
import onnxruntime
import pytest
import torch

from fusion.features.vt_vgg import build
from vtbench.cli import main
from vtbench.training import model_file
from vtbench.training.evidence import evidence, held_out_accuracy
from vtbench.training.fit import check_device, fit
from vtbench.training.model_file import read_story, write_model
from vtbench.training.network import VTVGG, Objective, levels_of
from vtbench.training.presses import pooled


def network(pooling="weighted"):
    """Weights and batch statistics away from their start."""
    torch.manual_seed(0)
    made = VTVGG(pooling).train()
    with torch.no_grad():
        made(torch.rand(4, 3, 64, 64) * 255)
    return made.eval()


def frames(n, seed=0):
    return np.random.default_rng(seed).integers(40, 200, (n, 256, 256, 3), dtype=np.uint8)


def presses(n=64, seed=0):
    """Bright spots: the place decides pressure and displacement, one of two sizes the shape."""
    rng = np.random.default_rng(seed)
    axis = np.arange(64)
    rows = []
    for i in range(n):
        u, v = rng.uniform(16, 48, 2)
        spot = np.exp(-((axis[:, None] - u) ** 2 + (axis[None] - v) ** 2) / (2 * (3 + 4 * (i % 2)) ** 2))
        sums = np.rint(16 * (128 + 30 * spot * np.array([1, -0.5, 0.3])[:, None, None]))
        small = spot.reshape(32, 2, 32, 2).mean(axis=(1, 3))
        rows.append((sums.astype(np.uint16), small.astype(np.float16), i % 2))
    sums, maps, shapes = (np.stack(part) for part in zip(*rows, strict=True))
    return {"frame": sums, "change": sums, "pressure": maps, "displacement": maps, "shape": shapes.astype(np.int64)}


def checks():
    made = frames(16, 1)
    return {
        "frame": made,
        "change": made,
        "shape": np.arange(16) % 4,
        "unit": np.arange(16) // 8,
        "any_pose": np.arange(16) % 8 >= 4,
    }


@pytest.mark.parametrize("pooling", ["mean", "weighted"])
def test_the_graph_is_the_network(pooling):
    made = network(pooling)
    images = frames(2)
    with torch.no_grad():
        expected = made(levels_of(np.stack([pooled(image) for image in images]))).numpy()
    session = onnxruntime.InferenceSession(build(made.arrays()), providers=["CPUExecutionProvider"])
    (found,) = session.run(["features"], {"images": images})
    assert found.shape == (2, 512)
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())


def test_a_brighter_lamp_changes_nothing():
    made = network()
    levels = torch.rand(2, 3, 64, 64) * 90 + 20
    brighter = (levels + 1) * torch.tensor([1.5, 1.0, 0.7])[None, :, None, None] - 1
    with torch.no_grad():
        plain, lit, mirrored = made(levels), made(brighter), made(levels.flip(3))
    assert (lit - plain).abs().max() < 1e-3 * plain.abs().max()
    assert (mirrored - plain).abs().max() > 0.05 * plain.abs().max()


@pytest.mark.slow
def test_training_learns_repeats_and_takes_the_best_later_epoch():
    first = fit(presses(), checks(), Objective(), epochs=4, seed=1)
    again = fit(presses(), checks(), Objective(), epochs=4, seed=1)
    assert first.losses[-1] < 0.9 * first.losses[0]
    assert first.best_epoch in (2, 3)
    assert first.weights.keys() == again.weights.keys()
    for name, values in first.weights.items():
        np.testing.assert_array_equal(values, again.weights[name])


def test_evidence_sees_shapes_and_is_not_fooled_by_units():
    rng = np.random.default_rng(0)
    labels, units = np.tile(np.arange(10), 12), np.repeat(np.arange(4), 30)
    told, by_unit = (
        rng.normal(size=(10, 40)).astype(np.float32)[of] + rng.normal(0, 0.05, (120, 40)).astype(np.float32)
        for of in (labels, units)
    )
    assert held_out_accuracy(told, labels, units) == 1
    assert held_out_accuracy(by_unit, labels, units) < 0.3
    anywhere = np.arange(120) % 2 == 0
    found = evidence(told, by_unit, {"shape": labels, "unit": units, "any_pose": anywhere})
    assert found.change_same_pose == found.change_any_pose == 1
    assert found.mean == pytest.approx((2 + found.frame_same_pose + found.frame_any_pose) / 4)


def test_a_model_file_tells_how_it_was_made(tmp_path, monkeypatch):
    path = tmp_path / "made.onnx"
    size = write_model(path, network().arrays(), {"command": "vtbench train-backbone", "training": {"seed": 5}})
    assert size == path.stat().st_size < model_file.LARGEST_BYTES
    story = read_story(path)
    assert story["command"] == "vtbench train-backbone"
    assert json.loads(story["training"]) == {"seed": 5}
    monkeypatch.setattr(model_file, "LARGEST_BYTES", 1000)
    with pytest.raises(ValueError, match="expected at most 1000"):
        write_model(tmp_path / "large.onnx", network().arrays(), {})
    assert not (tmp_path / "large.onnx").exists()


def test_a_device_that_is_not_there_is_refused(monkeypatch):
    check_device("cpu")
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    with pytest.raises(ValueError, match="finds no CUDA device; use --device cpu"):
        check_device("cuda")
    with pytest.raises(ValueError, match="expected cpu or cuda, got 'tpu'"):
        check_device("tpu")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["-o", "model.pt"], "expected a file that ends in .onnx"),
        (["-o", "m.onnx", "--images", "10"], "whole number of at least 64"),
        (["-o", "m.onnx", "--device", "cdua"], "did you mean 'cuda'"),
        (["-o", "m.onnx", "--epochs", "0"], "whole number of at least 1"),
    ],
)
def test_bad_input_is_one_line(words, says, capsys):
    assert main(["train-backbone", *words]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1
