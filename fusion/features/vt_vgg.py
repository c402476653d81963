"""`vt-vgg`: a small net in the manner of VGG for tactile frames, as an ONNX graph: uint8 images in, 512 features out.

Area stem: means over 4 x 4 pixels, logarithm, minus each colour's mean over the image. In the logarithm the cloth is
one term common to the colours and the strength of a light one constant, so that the convolutions can tell them from
the slopes of the skin. Then 3 x 3 convolutions with ReLU and max-pooling, and global pooling over the last 8 x 8 map,
plain or with a weight for every channel and place.

The committed weights are in `vt_vgg.onnx`; `vt_vgg.md` says how they were made.
"""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

import numpy as np

from fusion.features.onnx_graph import GraphBuilder, Weights, fold_batch_norm

DIM = 512
SIDE = 256  # pixels of an FVSight frame; another size is resized to it first
PARTS = 64
WIDTHS = ((24,), (48, 48), (96, 96), (192, 192))
"""Channels of the 3 x 3 convolutions; max-pooling halves the map between two tuples."""
GAIN = 16.0
"""Scale of the logarithms, so that a press changes them by about one."""
BATCH_NORM_EPSILON = 1e-5
FILE = Path(__file__).with_name("vt_vgg.onnx")


def build(weights: Weights) -> bytes:
    """The model with input `images` uint8 (N, H, W, 3) and output `features` (N, 512).

    `weights` names arrays as the network that is trained does: `stages.S.C.{conv,norm}.*`, `head.{conv,norm}.*` and,
    for weighted pooling, `pool.weight` (512, 1, 8, 8). KeyError where one is missing.
    """
    from onnx import TensorProto

    graph = GraphBuilder()

    def layer(x: str, name: str, pad: int) -> str:
        kernel, bias = fold_batch_norm(weights[f"{name}.conv.weight"], weights, f"{name}.norm", BATCH_NORM_EPSILON)
        return graph.node("Relu", graph.convolution(x, kernel, bias, pads=[pad] * 4))

    x = graph.pixels("images", np.full(3, -1.0, np.float32), np.ones(3, np.float32))
    x = graph.node("Log", graph.averaged(x, SIDE, PARTS))
    x = graph.node("Sub", x, graph.node("GlobalAveragePool", x))
    x = graph.node("Mul", x, graph.constant(np.array(GAIN, np.float32)))
    for s, stage in enumerate(WIDTHS):
        if s:
            x = graph.node("MaxPool", x, kernel_shape=[2, 2], strides=[2, 2])
        for c in range(len(stage)):
            x = layer(x, f"stages.{s}.{c}", 1)
    x = layer(x, "head", 0)
    if "pool.weight" in weights:
        x = graph.convolution(x, weights["pool.weight"], np.zeros(DIM, np.float32), group=DIM)
    else:
        x = graph.node("GlobalAveragePool", x)
    features = graph.node("Flatten", x, axis=1)
    return graph.model({"images": (TensorProto.UINT8, ["N", "H", "W", 3])}, {"features": (features, ["N", DIM])})


@cache
def committed() -> tuple[int, str]:
    """Size in bytes and SHA-256 of the committed model; OSError where the installation lacks it."""
    content = FILE.read_bytes()
    return len(content), hashlib.sha256(content).hexdigest()
