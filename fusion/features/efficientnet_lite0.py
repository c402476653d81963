"""EfficientNet-Lite0 as an ONNX graph: uint8 images in, 1280 pooled features out.

EfficientNet (Tan, Le 2019) for devices: ReLU6 in place of swish, no squeeze-and-excitation, stem and head of
fixed width. The pixels are (x - 127) / 128, as the network was trained. The padding is TensorFlow's "SAME"
(more below and to the right where it is odd). The whole image is resized to 224 x 224 (bilinear, no
smoothing first: meant for frames of about that size), nothing is cut off; larger images as they are cost more
and are recognised less surely.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fusion.features.onnx_graph import GraphBuilder, Weights, fold_batch_norm

DIM = 1280
N_CLASSES = 1000
SIDE = 224  # pixels, the size it was trained at
BATCH_NORM_EPSILON = 1e-3


@dataclass(frozen=True)
class Stage:
    """A run of inverted-residual blocks; the first has the stride and changes the width."""

    repeats: int
    kernel: int
    stride: int
    expand: int
    width: int


STAGES = (
    Stage(1, 3, 1, 1, 16),
    Stage(2, 3, 2, 6, 24),
    Stage(2, 5, 2, 6, 40),
    Stage(3, 3, 2, 6, 80),
    Stage(3, 5, 1, 6, 112),
    Stage(4, 5, 2, 6, 192),
    Stage(1, 3, 1, 6, 320),
)


def build(weights: Weights) -> bytes:
    """The model with inputs `images` uint8 (N, H, W, 3) and outputs `features` (N, 1280), `logits` (N, 1000).

    `weights` is the published state dict as arrays; every one of its entries is used. KeyError where one is
    missing, ValueError where one is left over.
    """
    from onnx import TensorProto

    left = {name for name in weights if not name.endswith("num_batches_tracked")}
    graph = GraphBuilder()

    def layer(x: str, conv: str, norm: str, stride: int = 1, relu6: bool = True) -> str:
        kernel = weights[f"{conv}.weight"]
        left.difference_update(
            [f"{conv}.weight", *(f"{norm}.{part}" for part in ("weight", "bias", "running_mean", "running_var"))]
        )
        folded, bias = fold_batch_norm(kernel, weights, norm, BATCH_NORM_EPSILON)
        groups = len(kernel) if "depthwise" in conv else 1
        x = graph.convolution(x, folded, bias, strides=[stride, stride], group=groups, auto_pad="SAME_UPPER")
        return graph.node("Clip", x, zero, six) if relu6 else x

    zero, six = (graph.constant(np.array(value, dtype=np.float32)) for value in (0.0, 6.0))
    x = graph.pixels("images", np.full(3, 127.0, np.float32), np.full(3, 1 / 128, np.float32))
    x = graph.resize(x, SIDE)
    x = layer(x, "_conv_stem", "_bn0", stride=2)
    block = 0
    for stage in STAGES:
        for repeat in range(stage.repeats):
            name, start = f"_blocks.{block}", x
            if stage.expand > 1:
                x = layer(x, f"{name}._expand_conv", f"{name}._bn0")
            x = layer(x, f"{name}._depthwise_conv", f"{name}._bn1", stride=1 if repeat else stage.stride)
            x = layer(x, f"{name}._project_conv", f"{name}._bn2", relu6=False)
            if repeat:
                x = graph.node("Add", x, start)
            block += 1
    x = layer(x, "_conv_head", "_bn1")
    features = graph.node("Flatten", graph.node("GlobalAveragePool", x), axis=1)
    head, offset = graph.constant(weights["_fc.weight"]), graph.constant(weights["_fc.bias"])
    logits = graph.node("Gemm", features, head, offset, transB=1)
    left.difference_update(["_fc.weight", "_fc.bias"])
    if left:
        raise ValueError(f"weights of another network: {len(left)} entries are not used, as {min(left)}.")
    return graph.model(
        {"images": (TensorProto.UINT8, ["N", "H", "W", 3])},
        {"features": (features, ["N", DIM]), "logits": (logits, ["N", N_CLASSES])},
    )
