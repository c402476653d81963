"""The ends of a pipeline's graph: raw inputs that may hold anything, frames through a backbone, scores of float32."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from onnx import TensorProto

from fusion.onnx.builder import Graph, integers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fusion.features.backbone import Backbone

LARGEST = float(np.finfo(np.float32).max)


def float_input(g: Graph, name: str, shape: list[int | str]) -> tuple[str, str]:
    """Declare a float32 input: its values as double, 0 where they are not finite, and which rows are finite (N, 1)."""
    given = g.input(name, TensorProto.FLOAT, shape)
    finite = g.op("LessOrEqual", g.op("Abs", given), np.array(LARGEST, np.float32))  # false for NaN
    values = g.double(g.op("Where", finite, given, np.array(0.0, np.float32)))
    flat = g.op("Flatten", g.op("Cast", finite, to=TensorProto.FLOAT), axis=1)
    whole = g.op("Greater", g.op("ReduceMin", flat, integers(1), keepdims=1), np.array(0.5, np.float32))
    return values, whole


def frame_change(g: Graph, frames: str, rest: str) -> str:
    """Frames minus rest frames about mid-grey, cut to uint8."""
    apart = g.op("Sub", *(g.op("Cast", each, to=TensorProto.INT32) for each in (frames, rest)))
    grey = g.op("Add", apart, np.array(128, np.int32))
    return g.op("Cast", g.op("Clip", grey, np.array(0, np.int32), np.array(255, np.int32)), to=TensorProto.UINT8)


def backbone_features(g: Graph, backbone: Backbone, frames: str) -> str:
    """Features (N, dim) of uint8 frames, in the float32 of the network, as double."""
    return g.double(g.include(backbone.onnx_model(), {"images": frames}, "features"))


def halves(g: Graph, decision: str) -> str:
    """Scores (N, 2), minus and plus half, of a decision (N, 1) between two classes, as every classifier answers it.

    The difference of two scores would lose digits where each is written in float32 and both are large.
    """
    return g.op("Concat", g.op("Mul", decision, -0.5), g.op("Mul", decision, 0.5), axis=1)


def between_two(g: Graph, scores: str) -> str:
    """Scores (N, 2) with the same difference that add up to 0."""
    first, second = (g.op("Slice", scores, integers(i), integers(i + 1), integers(1)) for i in (0, 1))
    return halves(g, g.op("Sub", second, first))


def score_output(g: Graph, scores: str, classes: Sequence[int], n_classes: int, finite: Sequence[str]) -> None:
    """Declare `scores` (N, n_classes) float32 of scores (N, len(classes)), double.

    A class that is not among `classes` scores finitely below all others. A row that is not `finite` is NaN, the others
    never are, nor infinite.
    """
    scores = g.op("Max", g.op("Min", scores, LARGEST), -LARGEST)
    if list(classes) != list(range(n_classes)):
        lowest, highest = (g.op(each, scores, integers(1), keepdims=1) for each in ("ReduceMin", "ReduceMax"))
        below = g.op("Sub", lowest, g.op("Add", g.op("Sub", highest, lowest), 1.0))
        place = np.full(n_classes, len(classes))
        place[list(classes)] = np.arange(len(classes))
        scores = g.op("Gather", g.op("Concat", scores, g.op("Max", below, -LARGEST), axis=1), place, axis=1)
    if finite:
        scores = g.op("Where", g.every(*finite), scores, np.array(np.nan))
    g.output("scores", g.op("Cast", scores, to=TensorProto.FLOAT), ["N", n_classes])
