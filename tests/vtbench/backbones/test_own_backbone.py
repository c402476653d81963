"""A backbone of one's own: taken by its path wherever a name is, and never mistaken for another file."""

import json
import pickle

import numpy as np
import onnx
import pytest
import yaml
from onnx import TensorProto, helper

from fusion.features import get_backbone, pixels
from tests.vtbench.run import small
from vtbench.config import load_suite
from vtbench.run.features import DiskFeatures
from vtbench.tasks import TASKS
from vtbench.tasks.presses import backbone_identity

FRAMES = np.random.default_rng(0).integers(0, 256, (3, 256, 256, 3), dtype=np.uint8)
TASK = "objects/interference/v1"


def write(path, gain=1.0):
    """Plain pixels times a gain, as a file."""
    model = onnx.load_from_string(pixels.build())
    (last,) = (node for node in model.graph.node if "features" in node.output)
    last.output[0] = "plain"
    model.graph.initializer.append(helper.make_tensor("gain", TensorProto.FLOAT, [], [gain]))
    model.graph.node.append(helper.make_node("Mul", ["plain", "gain"], ["features"]))
    path.write_bytes(model.SerializeToString())
    return path


def graph(path, shape=("N", "H", "W", 3), kind=TensorProto.UINT8, name="images", out="features", flat=True):
    """The frames themselves as floats, under the names and shapes that are asked for."""
    nodes = [helper.make_node("Cast", [name], ["x"], to=TensorProto.FLOAT)]
    nodes.append(helper.make_node("Flatten" if flat else "Identity", ["x"], [out]))
    given = helper.make_tensor_value_info(name, kind, list(shape))
    made = helper.make_tensor_value_info(out, TensorProto.FLOAT, None)
    opset = [helper.make_opsetid("", 18)]
    model = helper.make_model(helper.make_graph(nodes, "g", [given], [made]), opset_imports=opset, ir_version=9)
    path.write_bytes(model.SerializeToString())
    return path


def suite_file(folder, name, data, **entry):
    content = {
        "id": "mine",
        "title": "own backbone",
        "backbone": name,
        "datasets": [{"id": "own", "path": str(data)}],
        "entries": [
            {"task": TASK, "variants": ["own"], "splits": ["random"], "modalities": ["image"], "methods": ["knn"]}
            | {"probes": False}
            | entry
        ],
    }
    path = folder / "suite.yaml"
    path.write_text(yaml.safe_dump(content))
    return path


@pytest.fixture(scope="module")
def presses(tmp_path_factory):
    return small.write(tmp_path_factory.mktemp("presses") / "set")


def test_a_file_answers_as_the_graph_in_it(tmp_path):
    own, plain = get_backbone(str(write(tmp_path / "mine.onnx", 2.0))), get_backbone("pixels")
    assert own.dim == plain.dim
    np.testing.assert_allclose(own.extract(FRAMES), 2 * plain.extract(FRAMES), rtol=1e-6)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(own)).extract(FRAMES), own.extract(FRAMES))
    assert [each.name for each in own.onnx_model().graph.output] == ["features"]


def test_two_files_never_share_a_name_nor_features(tmp_path, presses):
    """The same path with another content is another backbone, and so is the same content under another name."""
    path = write(tmp_path / "mine.onnx")
    seen = [backbone_identity(str(path))]
    cache = DiskFeatures(tmp_path / "features")
    first = TASKS.get(TASK).load(presses, cache, str(path)).block("image")
    write(path, 2.0)
    seen.append(backbone_identity(str(path)))
    second = TASKS.get(TASK).load(presses, cache, str(path)).block("image")
    np.testing.assert_allclose(second, 2 * first, rtol=1e-6)
    (tmp_path / "elsewhere").mkdir()
    seen += [backbone_identity(str(write(tmp_path / "elsewhere" / "mine.onnx", 3.0)))]
    seen += [backbone_identity(str(write(tmp_path / "other.onnx")))]
    assert len({each["backbone"] for each in seen}) == 4
    assert seen[0]["backbone"].startswith("mine-")
    assert seen[0]["backbone_sha256"] == seen[3]["backbone_sha256"]
    assert str(tmp_path) not in json.dumps(seen)  # where a file lies says nothing about a result
    same = write(tmp_path / "elsewhere" / "mine.onnx")
    assert backbone_identity(str(same)) == seen[0]


def test_a_suite_names_a_file_from_its_own_folder(tmp_path, presses, monkeypatch):
    write(tmp_path / "mine.onnx")
    suite = suite_file(tmp_path, "mine.onnx", presses, backbone="./mine.onnx")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    read = load_suite("../suite.yaml")
    assert read.backbone == read.entries[0].backbone == str((tmp_path / "mine.onnx").resolve())
    suite_file(tmp_path, "gone.onnx", presses)
    with pytest.raises(ValueError, match=r"suite\.yaml: backbone: no backbone '.*gone\.onnx': expected an ONNX file"):
        load_suite(suite)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda path: None, "expected an ONNX file"),
        (lambda path: path.write_text("not a graph"), "not a model that ONNX Runtime opens"),
        (lambda path: graph(path, name="input"), r"expected one input 'images' uint8 .*, got 'input' uint8"),
        (lambda path: graph(path, kind=TensorProto.FLOAT), r"expected one input 'images' uint8 .*, got 'images' float"),
        (lambda path: graph(path, ("N", 3, 256, 256)), r"expected one input .*, got 'images' uint8 \('N', 3, 256, 256"),
        (lambda path: graph(path, (8, 256, 256, 3)), r"expected one input .*, got 'images' uint8 \(8, 256, 256, 3"),
        (lambda path: graph(path, out="logits"), "expected an output 'features'"),
        (
            lambda path: graph(path, flat=False),
            r"expected 'features' float32 \(N, columns\), got float32 \(1, 256, 256",
        ),
    ],
)
def test_what_is_no_backbone_is_refused_in_one_line(make, says, tmp_path):
    make(tmp_path / "x.onnx")
    with pytest.raises(ValueError, match=says) as refused:
        get_backbone(str(tmp_path / "x.onnx"))
    assert "\n" not in str(refused.value)


def test_frames_of_another_size_than_the_file_takes_are_refused(tmp_path):
    own = get_backbone(str(graph(tmp_path / "fixed.onnx", ("N", 8, 8, 3))))
    assert own.dim == 8 * 8 * 3
    np.testing.assert_array_equal(own.extract(FRAMES[:, :8, :8])[1], FRAMES[1, :8, :8].ravel())
    with pytest.raises(ValueError, match=r"takes frames of 8 x 8, got \(256, 256\)"):
        own.extract(FRAMES)


def test_a_missing_file_is_refused_before_anything_is_simulated(refused, tmp_path):
    words = ("export", TASK, "knn", "--modality", "image", "-o", tmp_path / "out.onnx")
    assert "expected an ONNX file" in refused(*words, "--backbone", tmp_path / "gone.onnx")


@pytest.mark.slow
def test_a_file_is_run_compared_and_exported(vtbench, refused, presses, tmp_path, monkeypatch):
    timed = []
    monkeypatch.setattr("vtbench.backbones.cost.frame_costs", lambda names, frames: timed.append(names) or [])
    own = write(tmp_path / "mine.onnx")
    suite = suite_file(tmp_path, "mine.onnx", presses)
    content = yaml.safe_load(suite.read_text())
    content["entries"].append({**content["entries"][0], "backbone": "pixels"})
    suite.write_text(yaml.safe_dump(content))
    assert vtbench("run", suite, "-o", tmp_path / "out").code == 0
    listed = json.loads(vtbench("backbones", tmp_path / "out", "--json").out)
    name = get_backbone(str(own)).name
    by_name = {score["backbone"]: score["value"] for score in listed["scores"]}
    assert by_name[name] == by_name["pixels"]
    assert timed[0][-1] == str(own)
    made = tmp_path / "made.onnx"
    words = ("export", TASK, "knn", "--modality", "image", "--variant", "own", "--data", presses, "-o", made)
    assert vtbench(*words, "--backbone", own).code == 0
    (report,) = (json.loads(each.value) for each in onnx.load(made).metadata_props if each.key == "vtbench")
    assert report["backbone"] == name
    own.unlink()
    assert "not timed" in vtbench("backbones", tmp_path / "out").err
    assert str(own) not in timed[1]
    fused = suite_file(tmp_path, "pixels", presses, modalities=["fused-equal"])
    assert vtbench("run", fused, "-o", tmp_path / "fused").code == 0
    assert "scores of image or image-change alone, found none" in refused("backbones", tmp_path / "fused")
