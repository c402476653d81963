"""Image backbones by name: uint8 frames to pooled features, one interface."""

from __future__ import annotations

import difflib
import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fusion.features import efficientnet_lite0, pixels, vgg16, vt_vgg
from fusion.features.own_file import is_own_file, read_own_file
from fusion.features.weights_cache import downloaded_vgg16, kept_graph, packaged_efficientnet_lite0

if TYPE_CHECKING:
    import onnx

GRAPH_VERSION = 1  # raise when a graph built from the same weights changes
NO_WEIGHTS = hashlib.sha256(b"").hexdigest()


@dataclass(frozen=True)
class Backbone:
    """One image network with what it costs and whose it is; nothing is loaded before `extract`.

    Attributes
    ----------
    name : as in `get_backbone`; of a file its stem and the first eight digits of its SHA-256.
    dim : features per image.
    licence : of the weights.
    size_bytes : of the published weights file.
    weights_sha256 : of that file, whole or as many leading digits as its publisher states; "random" for
        random weights, that of no bytes where there are no weights.
    threads : of ONNX Runtime on the CPU; bits are promised for 1.
    """

    name: str
    dim: int
    licence: str
    size_bytes: int
    weights_sha256: str
    threads: int
    _build: Callable[[], bytes]
    _keep: bool = True
    _file: str = ""
    _size: tuple[int | None, int | None] = (None, None)

    def extract(self, images: ArrayLike) -> NDArray[np.float32]:
        """Features (N, dim) float32 of RGB `images` uint8 (N, H, W, 3), any height and width.

        Images go through the network one by one: a row depends on its image alone, to the bit, however the
        images are batched or shared out among processes; it is also no slower on a CPU. Resizing and the pixel
        scale of the network are part of it.

        ValueError for another shape or type; OSError where the weights cannot be had.
        """
        frames = np.asarray(images)
        if frames.ndim != 4 or frames.shape[3] != 3 or frames.dtype != np.uint8:
            raise ValueError(f"images must be uint8 of shape (N, H, W, 3), got {frames.dtype} of shape {frames.shape}.")
        if any(want not in (None, got) for want, got in zip(self._size, frames.shape[1:3], strict=True)):
            raise ValueError(f"{self.name} takes frames of {self._size[0]} x {self._size[1]}, got {frames.shape[1:3]}.")
        features = np.empty((len(frames), self.dim), dtype=np.float32)
        for i, frame in enumerate(frames):
            features[i] = self._session.run(["features"], {"images": np.ascontiguousarray(frame[None])})[0][0]
        return features

    def onnx_model(self) -> onnx.ModelProto:
        """The graph as an `onnx.ModelProto`: input `images` uint8 (N, H, W, 3), output `features` (N, dim) float32.

        For merging into the graph of a whole pipeline. Outputs beside `features` are left out, with the nodes that
        only they need. OSError where the weights cannot be had.
        """
        import onnx

        from fusion.features.onnx_graph import only_output

        try:
            return only_output(onnx.load_from_string(self._graph()), "features")
        except _parse_errors():
            return only_output(onnx.load_from_string(self._graph(fresh=True)), "features")

    @cached_property
    def _session(self) -> Any:
        try:
            return _session(self._graph(), self.threads)
        except _graph_errors():
            return _session(self._graph(fresh=True), self.threads)

    def _graph(self, *, fresh: bool = False) -> bytes:
        """The serialised graph: what an earlier run kept of it, or built now."""
        if not self._keep:
            return self._build()
        return kept_graph(f"{self.name}-{self.weights_sha256[:16]}-v{GRAPH_VERSION}", self._build, fresh=fresh)

    def __reduce__(self) -> tuple[Any, ...]:
        weights = "random" if self.weights_sha256 == "random" else "pretrained"
        return _restore, (self._file or self.name, self.threads, weights)


def backbone_names() -> tuple[str, ...]:
    """Names that `get_backbone` knows; the first works offline."""
    return ("efficientnet-lite0", "pixels", "vgg16", "vt-vgg")


def get_backbone(name: str, *, threads: int = 1, weights: Literal["pretrained", "random"] = "pretrained") -> Backbone:
    """Backbone by name.

    "efficientnet-lite0" : 1280 features; ImageNet weights from an installed package, no network; the whole
        image is resized to 224 x 224.
    "pixels" : 3072 numbers, no network: the image averaged to 32 x 32; what every other backbone must beat.
    "vgg16" : 512 features, the FVSight paper's; ImageNet weights through torchvision, network once; images
        keep their size. `weights="random"` is for measuring its speed where the weights cannot be had.
    "vt-vgg" : 512 features; a small net trained on simulated presses of shapes that are not among the household
        objects, see `vt_vgg.md`; offline.
    "path/to/file.onnx" : a file of one's own: `images` uint8 (N, height, width, 3) in, `features` (N, columns) float32
        out, as `vtbench train-backbone` writes it.

    ValueError for an unknown name, with the closest known one, and for a file that is no such model.
    """
    if is_own_file(name):
        if weights != "pretrained":
            raise ValueError(f"{name} has no weights {weights!r}; use 'pretrained' (vgg16 also has 'random').")
        own = read_own_file(Path(name).expanduser())
        return Backbone(
            own.name,
            own.dim,
            "own",
            own.size_bytes,
            own.sha256,
            threads,
            own.content,
            _keep=False,
            _file=str(own.path),
            _size=own.size,
        )
    if name == "efficientnet-lite0" and weights == "pretrained":
        sha256 = "579344248a93e23026e6b78f1f6faf0bc1d282386f6c881cdbaacd49cabf77db"
        return Backbone(
            name,
            efficientnet_lite0.DIM,
            "Apache-2.0",
            18_826_032,
            sha256,
            threads,
            lambda: efficientnet_lite0.build(packaged_efficientnet_lite0(sha256)),
        )
    if name == "pixels" and weights == "pretrained":
        return Backbone(name, pixels.DIM, "Apache-2.0", 0, NO_WEIGHTS, threads, pixels.build, _keep=False)
    if name == "vgg16" and weights == "pretrained":
        return Backbone(
            name,
            vgg16.DIM,
            "BSD-3-Clause",
            553_433_881,
            "397923af",
            threads,
            lambda: vgg16.build(downloaded_vgg16()),
        )
    if name == "vgg16" and weights == "random":
        return Backbone(
            name, vgg16.DIM, "none", 0, "random", threads, lambda: vgg16.build(vgg16.random_weights()), _keep=False
        )
    if name == "vt-vgg" and weights == "pretrained":
        size, sha256 = vt_vgg.committed()
        return Backbone(name, vt_vgg.DIM, "Apache-2.0", size, sha256, threads, vt_vgg.FILE.read_bytes, _keep=False)
    if name in backbone_names():
        raise ValueError(f"{name} has no weights {weights!r}; use 'pretrained' (vgg16 also has 'random').")
    close = difflib.get_close_matches(name, backbone_names(), n=1)
    hint = f"; did you mean {close[0]}?" if close else ""
    raise ValueError(f"no backbone {name!r}; known are {', '.join(backbone_names())}{hint}")


def _restore(name: str, threads: int, weights: Literal["pretrained", "random"]) -> Backbone:
    return get_backbone(name, threads=threads, weights=weights)


def _session(graph: bytes, threads: int) -> Any:
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 3
    return onnxruntime.InferenceSession(graph, options, providers=["CPUExecutionProvider"])


def _graph_errors() -> tuple[type[Exception], ...]:
    """What ONNX Runtime raises for a file that is no valid graph."""
    from onnxruntime.capi import onnxruntime_pybind11_state as state

    return (state.InvalidProtobuf, state.InvalidGraph, state.InvalidArgument, state.Fail)


def _parse_errors() -> tuple[type[Exception], ...]:
    """What `onnx` raises for bytes that are no model, or for a model without what it should give."""
    from google.protobuf.message import DecodeError  # type: ignore[import-untyped]

    return (DecodeError, KeyError)
