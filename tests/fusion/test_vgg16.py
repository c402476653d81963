"""VGG-16 and the torchvision it comes through."""

import subprocess
import sys

import numpy as np
import pytest
import torch

from fusion.features import get_backbone, torchvision_compat, vgg16, weights_cache


@pytest.fixture(scope="module")
def torchvision():
    return torchvision_compat.import_torchvision()


def test_equals_torchvision_with_the_same_weights(torchvision):
    from torchvision.models import vgg16 as build

    reference = build(weights=None).features.eval()
    weights = {name.removeprefix("features."): torch.from_numpy(w) for name, w in vgg16.random_weights().items()}
    reference.load_state_dict(weights, strict=True)
    images = np.random.default_rng(0).integers(0, 256, (2, 64, 96, 3), dtype=np.uint8)
    scaled = (torch.from_numpy(images).permute(0, 3, 1, 2).float() / 255 - torch.tensor(vgg16.MEAN)[:, None, None]) / (
        torch.tensor(vgg16.STD)[:, None, None]
    )
    with torch.no_grad():
        expected = reference(scaled).mean(dim=(2, 3)).numpy()
    found = get_backbone("vgg16", weights="random").extract(images)
    assert found.shape == (2, 512)
    np.testing.assert_allclose(found, expected, atol=1e-4)


@pytest.mark.parametrize("failure", [OSError("no route to host\nsecond line"), RuntimeError("invalid hash value")])
def test_weights_that_cannot_be_had_are_an_error_in_one_line(torchvision, monkeypatch, failure):
    from torchvision.models import VGG16_Weights

    def fail(*args, **kwargs):
        raise failure

    monkeypatch.setattr(VGG16_Weights, "get_state_dict", fail)
    with pytest.raises(OSError, match=r"vgg16: its weights .* could not be had") as caught:
        weights_cache.downloaded_vgg16()
    message = str(caught.value)
    assert "\n" not in message
    assert "vgg16-397923af.pth" in message
    assert "efficientnet-lite0" in message


def test_torchvision_imports_beside_any_torch():
    code = (
        "from fusion.features import import_torchvision\n"
        "tv = import_torchvision()\n"
        "from torchvision.models import vgg16\n"
        "print(tv.__version__, sum(p.numel() for p in vgg16().features.parameters()))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    assert found.stdout.split()[1] == "14714688"


def test_a_matching_pair_is_left_alone(monkeypatch):
    defined = []
    monkeypatch.setattr(torch.ops, "load_library", lambda path: None)
    monkeypatch.setattr(torch.library, "define", lambda *args: defined.append(args))
    torchvision_compat.import_torchvision()
    assert defined == []


def test_schemas_are_defined_once_where_the_library_does_not_load(monkeypatch):
    def refuse(path):
        raise OSError("undefined symbol")

    defined = []
    monkeypatch.setattr(torch.ops, "load_library", refuse)
    monkeypatch.setattr(torch.library, "define", lambda *args: defined.append(args))
    monkeypatch.setattr(torchvision_compat, "SCHEMAS", {"torchvision::never_defined": "(Tensor x) -> Tensor"})
    torchvision_compat.import_torchvision()
    assert defined == [("torchvision::never_defined", "(Tensor x) -> Tensor")]


def test_a_missing_torchvision_is_named(monkeypatch):
    monkeypatch.setattr(torchvision_compat.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match="torchvision is not installed"):
        torchvision_compat.own_library_loads()
