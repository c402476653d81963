"""The convolutions of VGG-16 as an ONNX graph: uint8 images in, 512 pooled features out.

VGG-16 (Simonyan, Zisserman 2015). The images keep their size, 256 x 256 in the FVSight paper: the convolutions
take any, and the 512 features are the last map's averages over the image.
"""

from __future__ import annotations

import numpy as np

from fusion.features.onnx_graph import GraphBuilder, Weights

DIM = 512
MEAN = np.array([0.485, 0.456, 0.406], dtype=np.float32)
STD = np.array([0.229, 0.224, 0.225], dtype=np.float32)
STAGES = ((64, 64), (128, 128), (256, 256, 256), (512, 512, 512), (512, 512, 512))


def layer_numbers() -> list[tuple[str, int, int, bool]]:
    """(name in the state dict, channels in, channels out, whether pooling follows) of each convolution."""
    layers, place, width = [], 0, 3
    for stage in STAGES:
        for i, out in enumerate(stage):
            last = i == len(stage) - 1
            layers.append((f"features.{place}", width, out, last))
            place, width = place + (3 if last else 2), out
    return layers


def build(weights: Weights) -> bytes:
    """The model with input `images` uint8 (N, H, W, 3) and output `features` (N, 512).

    `weights` is the published state dict as arrays; KeyError where a convolution is missing.
    """
    from onnx import TensorProto

    graph = GraphBuilder()
    x = graph.pixels("images", MEAN * np.float32(255), np.float32(1 / 255) / STD)
    for name, _, _, pool in layer_numbers():
        x = graph.convolution(x, weights[f"{name}.weight"], weights[f"{name}.bias"], pads=[1, 1, 1, 1])
        x = graph.node("Relu", x)
        if pool:
            x = graph.node("MaxPool", x, kernel_shape=[2, 2], strides=[2, 2])
    features = graph.node("Flatten", graph.node("GlobalAveragePool", x), axis=1)
    return graph.model({"images": (TensorProto.UINT8, ["N", "H", "W", 3])}, {"features": (features, ["N", DIM])})


def random_weights(seed: int = 0) -> dict[str, np.ndarray]:
    """He-normal weights of the right shapes: for measuring speed where the real ones cannot be had."""
    rng = np.random.default_rng(seed)
    weights = {}
    for name, width, out, _ in layer_numbers():
        scale = np.sqrt(2 / (9 * width))
        weights[f"{name}.weight"] = scale * rng.standard_normal((out, width, 3, 3), dtype=np.float32)
        weights[f"{name}.bias"] = np.zeros(out, dtype=np.float32)
    return weights
