"""The image backbones: right numbers, a row per image to the bit, a cache that cannot hurt."""

import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import torch
from sklearn.datasets import load_sample_image
from torch import nn
from torch.nn import functional

from fusion.features import backbone as backbone_module
from fusion.features import backbone_names, efficientnet_lite0, get_backbone, weights_cache

NAME = "efficientnet-lite0"
PALACE, DAISY = 698, 985


class ConvNorm(nn.Module):
    """Convolution with TensorFlow's "SAME" padding, batch normalisation, perhaps ReLU6."""

    def __init__(self, relu6=True):
        super().__init__()
        self.relu6 = relu6

    @staticmethod
    def apply_to(x, conv, norm, relu6=True):
        (kernel, _), (stride, _) = conv.kernel_size, conv.stride
        total = [max((-(-side // stride) - 1) * stride + kernel - side, 0) for side in x.shape[2:]]
        pads = [total[1] // 2, total[1] - total[1] // 2, total[0] // 2, total[0] - total[0] // 2]
        x = norm(conv(functional.pad(x, pads)))
        return functional.relu6(x) if relu6 else x


def conv(inside, outside, kernel=1, stride=1, groups=1):
    return nn.Conv2d(inside, outside, kernel, stride, groups=groups, bias=False)


class Block(nn.Module):
    def __init__(self, inside, outside, kernel, stride, expand):
        super().__init__()
        middle = inside * expand
        self.expands, self.skips = expand > 1, stride == 1 and inside == outside
        if self.expands:
            self._expand_conv, self._bn0 = conv(inside, middle), nn.BatchNorm2d(middle, 1e-3)
        self._depthwise_conv = conv(middle, middle, kernel, stride, groups=middle)
        self._bn1 = nn.BatchNorm2d(middle, 1e-3)
        self._project_conv, self._bn2 = conv(middle, outside), nn.BatchNorm2d(outside, 1e-3)

    def forward(self, x):
        y = ConvNorm.apply_to(x, self._expand_conv, self._bn0) if self.expands else x
        y = ConvNorm.apply_to(y, self._depthwise_conv, self._bn1)
        y = ConvNorm.apply_to(y, self._project_conv, self._bn2, relu6=False)
        return x + y if self.skips else y


class EfficientNetLite0(nn.Module):
    """The architecture in torch, under the names of the published state dict."""

    def __init__(self):
        super().__init__()
        self._conv_stem, self._bn0 = conv(3, 32, 3, 2), nn.BatchNorm2d(32, 1e-3)
        blocks, width = [], 32
        for repeats, kernel, stride, expand, outside in (
            (1, 3, 1, 1, 16), (2, 3, 2, 6, 24), (2, 5, 2, 6, 40), (3, 3, 2, 6, 80),
            (3, 5, 1, 6, 112), (4, 5, 2, 6, 192), (1, 3, 1, 6, 320),
        ):  # fmt: skip
            for i in range(repeats):
                blocks.append(Block(width, outside, kernel, 1 if i else stride, expand))
                width = outside
        self._blocks = nn.ModuleList(blocks)
        self._conv_head, self._bn1 = conv(320, 1280), nn.BatchNorm2d(1280, 1e-3)
        self._fc = nn.Linear(1280, 1000)

    def forward(self, images):
        x = (images.permute(0, 3, 1, 2).float() - 127) / 128
        if x.shape[2:] != (224, 224):
            x = functional.interpolate(x, (224, 224), mode="bilinear", align_corners=False)
        x = ConvNorm.apply_to(x, self._conv_stem, self._bn0)
        for block in self._blocks:
            x = block(x)
        x = ConvNorm.apply_to(x, self._conv_head, self._bn1).mean(dim=(2, 3))
        return x, self._fc(x)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VTBENCH_CACHE", str(folder))
        yield folder


@pytest.fixture(scope="module")
def lite(cache):
    return get_backbone(NAME)


@pytest.fixture(scope="module")
def state():
    return weights_cache.packaged_efficientnet_lite0(get_backbone(NAME).weights_sha256)


def noise(n=3, side=256, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (n, side, side, 3), dtype=np.uint8)


def centre_square(name):
    image = load_sample_image(name)
    height, width, _ = image.shape
    side = min(height, width)
    top, left = (height - side) // 2, (width - side) // 2
    return np.ascontiguousarray(image[top : top + side, left : left + side])


def logits(model, images):
    return model._session.run(["logits"], {"images": images})[0]


@pytest.mark.parametrize("side", [224, 256])
def test_equals_the_architecture_in_torch_with_every_weight_loaded(lite, state, side):
    reference = EfficientNetLite0().eval()
    counters = {k: torch.tensor(0) for k in reference.state_dict() if k.endswith("num_batches_tracked")}
    reference.load_state_dict({**counters, **{k: torch.from_numpy(v) for k, v in state.items()}}, strict=True)
    images = np.stack([noise(1, side)[0], centre_square("flower.jpg")[:side, :side]])
    with torch.no_grad():
        features, scores = reference(torch.from_numpy(images))
    np.testing.assert_allclose(lite.extract(images), features.numpy(), rtol=0, atol=1e-4)
    np.testing.assert_allclose(logits(lite, images), scores.numpy(), rtol=0, atol=1e-3)


@pytest.mark.parametrize(("picture", "expected"), [("china.jpg", PALACE), ("flower.jpg", DAISY)])
def test_names_what_is_in_a_photograph(lite, picture, expected):
    assert logits(lite, centre_square(picture)[None]).argmax() == expected


def test_a_row_depends_on_its_image_alone(lite):
    images = noise(5)
    whole = lite.extract(images)
    assert whole.shape == (5, lite.dim)
    assert whole.dtype == np.float32
    for i, image in enumerate(images):
        np.testing.assert_array_equal(lite.extract(image[None])[0], whole[i])
    np.testing.assert_array_equal(get_backbone(NAME).extract(images[::-1])[::-1], whole)


def test_no_images_give_no_rows(lite):
    assert lite.extract(noise(0)).shape == (0, 1280)


def test_survives_pickling(lite):
    images = noise(1)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(lite)).extract(images), lite.extract(images))


@pytest.mark.parametrize(
    "images", [noise(1).astype(np.float32), noise(1)[0], noise(1)[..., :1], noise(1).transpose(0, 3, 1, 2)]
)
def test_other_arrays_are_refused(lite, images):
    with pytest.raises(ValueError, match=r"images must be uint8 of shape \(N, H, W, 3\)"):
        lite.extract(images)


def test_a_kept_graph_is_used_without_torch(cache, lite):
    lite.extract(noise(1))
    code = (
        "import sys, numpy as np\n"
        "from fusion.features import get_backbone\n"
        f"get_backbone('{NAME}').extract(np.zeros((1, 256, 256, 3), np.uint8))\n"
        "print(*sorted({'torch', 'onnx', 'sklearn'} & set(sys.modules)))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == []


def test_building_twice_gives_the_same_bytes(state):
    assert efficientnet_lite0.build(state) == efficientnet_lite0.build(state)


def test_a_damaged_graph_is_built_again(tmp_path, monkeypatch, lite):
    expected = lite.extract(noise(1))
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path))
    get_backbone(NAME).extract(noise(1))
    (kept,) = (tmp_path / "backbones").iterdir()
    whole = kept.read_bytes()
    for damaged in (whole[:1000], b"", b"not a graph"):
        kept.write_bytes(damaged)
        np.testing.assert_array_equal(get_backbone(NAME).extract(noise(1)), expected)
        assert kept.read_bytes() == whole


def test_a_cache_that_cannot_be_written_is_done_without(tmp_path, monkeypatch, lite):
    (tmp_path / "file").touch()
    expected = lite.extract(noise(1))
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path / "file"))
    np.testing.assert_array_equal(get_backbone(NAME).extract(noise(1)), expected)


def test_builders_at_once_leave_one_whole_graph(tmp_path, monkeypatch):
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path))
    graph = np.random.default_rng(1).bytes(300_000)
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: weights_cache.kept_graph("x", lambda: graph), range(40)))
    assert set(found) == {graph}
    assert [path.name for path in (tmp_path / "backbones").iterdir()] == ["x.onnx"]


def test_weights_of_another_file_are_refused():
    with pytest.raises(OSError, match=r"has SHA-256 579344248a93\.\.\., expected 000000000000"):
        weights_cache.packaged_efficientnet_lite0("0" * 64)


def test_weights_of_another_network_are_refused(state):
    with pytest.raises(ValueError, match="1 entries are not used, as stray"):
        efficientnet_lite0.build({**state, "stray": state["_fc.bias"]})
    with pytest.raises(KeyError, match=r"_fc\.bias"):
        efficientnet_lite0.build({k: v for k, v in state.items() if k != "_fc.bias"})


def test_every_name_says_what_it_is():
    for name in backbone_names():
        found = get_backbone(name)
        assert found.name == name
        assert found.dim > 0
        assert (found.size_bytes == 0) == (name == "pixels")
        assert found.licence
        int(found.weights_sha256, 16)


def test_a_misspelt_name_gets_the_closest_one():
    with pytest.raises(ValueError, match="did you mean vgg16"):
        get_backbone("vgg-16")
    with pytest.raises(ValueError, match="no weights 'random'"):
        get_backbone(NAME, weights="random")


def test_vgg16_without_weights_says_what_to_do(tmp_path, monkeypatch):
    def no_network() -> dict[str, np.ndarray]:
        raise OSError("vgg16: no network")

    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path))
    monkeypatch.setattr(backbone_module, "downloaded_vgg16", no_network)
    with pytest.raises(OSError, match="vgg16: no network"):
        get_backbone("vgg16").extract(noise(1, 32))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", [NAME, "pixels"])
def test_the_graph_for_merging_gives_the_same_features_and_nothing_else(cache, name):
    import onnx
    import onnxruntime

    found = get_backbone(name)
    model = found.onnx_model()
    onnx.checker.check_model(model, full_check=True)
    assert [value.name for value in model.graph.output] == ["features"]
    used = {entry for node in model.graph.node for entry in node.input}
    assert {constant.name for constant in model.graph.initializer} <= used
    session = onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    images = noise(2)
    rows = [session.run(None, {"images": image[None]})[0][0] for image in images]
    np.testing.assert_array_equal(np.stack(rows), found.extract(images))


def test_a_damaged_graph_is_no_hindrance_to_merging(tmp_path, monkeypatch, lite):
    expected = lite.onnx_model()
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path))
    get_backbone(NAME).onnx_model()
    (kept,) = (tmp_path / "backbones").iterdir()
    for damaged in (kept.read_bytes()[:1000], b""):
        kept.write_bytes(damaged)
        assert get_backbone(NAME).onnx_model() == expected


def test_pixels_are_means_over_squares():
    images = noise(2, 256)
    squares = images.reshape(2, 32, 8, 32, 8, 3).mean(axis=(2, 4)).transpose(0, 3, 1, 2) / 255
    np.testing.assert_allclose(get_backbone("pixels").extract(images), squares.reshape(2, -1), atol=1e-6)
    even = np.full((1, 100, 60, 3), 51, np.uint8)
    np.testing.assert_allclose(get_backbone("pixels").extract(even), 0.2, atol=1e-6)


def test_vt_vgg_is_committed_small_and_tells_how_it_was_made(cache):
    found = get_backbone("vt-vgg")
    assert found.dim == 512
    assert found.size_bytes <= 8_000_000
    model = found.onnx_model()
    story = {entry.key: entry.value for entry in model.metadata_props}
    assert story["command"].startswith("vtbench train-backbone --seed")
    assert len(story["training_data_sha256"]) == 64
    images = noise(3)
    whole = found.extract(images)
    assert whole.shape == (3, 512)
    for i, image in enumerate(images):
        np.testing.assert_array_equal(found.extract(image[None])[0], whole[i])
    assert np.linalg.norm(whole[0] - whole[1]) > 0.01 * np.linalg.norm(whole[0])
