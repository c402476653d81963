"""Plain pixels as a backbone: the frame averaged over squares, no network and no weights."""

from __future__ import annotations

import numpy as np

from fusion.features.onnx_graph import GraphBuilder

SIDE = 256  # pixels of an FVSight frame; another size is resized to it first
PARTS = 32
DIM = 3 * PARTS * PARTS


def build() -> bytes:
    """The model with input `images` uint8 (N, H, W, 3) and output `features` (N, 3072).

    A feature is the mean of 8 x 8 pixels of one colour, 0 to 1; colours outermost, then rows.
    """
    from onnx import TensorProto

    graph = GraphBuilder()
    x = graph.pixels("images", np.zeros(3, np.float32), np.full(3, 1 / 255, np.float32))
    features = graph.node("Flatten", graph.averaged(x, SIDE, PARTS), axis=1)
    return graph.model({"images": (TensorProto.UINT8, ["N", "H", "W", 3])}, {"features": (features, ["N", DIM])})
