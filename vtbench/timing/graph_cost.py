"""What a subject costs on any machine: parameters, multiply-accumulates of one sample, bytes, of its ONNX graph.

Multiply-accumulates are those of Conv, ConvTranspose, Gemm and MatMul; other operators, among them the differences
that a nearest neighbour takes, count none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from onnx import ModelProto, NodeProto

    from vtbench.run.fitted import FittedPipeline

Shape = tuple[int, ...]


@dataclass(frozen=True)
class GraphCost:
    """Counts of one graph.

    Attributes:
        params: elements of the graph's constants.
        macs: multiply-accumulates of one sample; None where shapes are not known before the graph runs.
        bytes: of its file.
    """

    params: int
    macs: int | None
    bytes: int


def graph_cost(model: ModelProto, shapes: Mapping[str, Sequence[int]]) -> GraphCost:
    """Count a graph.

    Args:
        model: without functions of its own.
        shapes: of each input, one sample: (1, ...).

    Raises:
        ValueError: an input that has no shape there.
    """
    constants = model.graph.initializer
    return GraphCost(sum(prod(each.dims) for each in constants), _macs(model, shapes), model.ByteSize())


def pipeline_model(pipeline: FittedPipeline, widths: Mapping[str, int]) -> ModelProto:
    """Graph of a fitted pipeline from the features on: an input (N, width) double for each block, scores out.

    Raises:
        ValueError: a classifier that has no exact graph.
    """
    from onnx import TensorProto

    from fusion.onnx import add_estimator
    from fusion.onnx.builder import Graph
    from vtbench.exporting.graph import reduced

    g = Graph()
    parts = []
    for number, (name, block) in enumerate(pipeline.blocks.items()):
        x = g.input(f"x{number}", TensorProto.DOUBLE, ["N", widths[name]])
        parts.append(reduced(g, block, x, widths[name]))
    scores = add_estimator(g, pipeline.classifier, parts[0] if len(parts) == 1 else g.op("Concat", *parts, axis=1))
    g.output("scores", g.op("Cast", scores, to=TensorProto.FLOAT), ["N", len(pipeline.classifier.classes_)])  # type: ignore[attr-defined]
    return g.model("pipeline")


def pipeline_cost(pipeline: FittedPipeline, widths: Mapping[str, int]) -> GraphCost | None:
    """Cost of a fitted pipeline from the features on, `widths` columns a block; None where it has no exact graph."""
    try:
        model = pipeline_model(pipeline, widths)
    except (ValueError, AttributeError):
        return None
    return graph_cost(model, {f"x{number}": (1, widths[name]) for number, name in enumerate(pipeline.blocks)})


def _macs(model: ModelProto, shapes: Mapping[str, Sequence[int]]) -> int | None:
    known = _shapes(model, shapes)
    total = 0
    for node in model.graph.node:
        if any(attribute.HasField("g") for attribute in node.attribute):
            return None  # a branch or a loop: how often it runs is in the data
        if node.op_type in _COUNTS:
            named = [known.get(name) for name in (*node.input[:2], node.output[0])]
            if any(shape is None for shape in named):
                return None
            x, weight, y = (shape for shape in named if shape is not None)
            total += _COUNTS[node.op_type](node, x, weight, y)
    return total


def _shapes(model: ModelProto, shapes: Mapping[str, Sequence[int]]) -> dict[str, Shape]:
    """Shapes of all tensors that shape inference knows, with the inputs' given."""
    import onnx

    held = {each.name: tuple(each.dims) for each in model.graph.initializer}
    given = onnx.ModelProto()
    given.CopyFrom(model)
    del given.graph.value_info[:]
    for each in given.graph.input:
        if each.name in held:
            continue
        if each.name not in shapes:
            raise ValueError(f"input {each.name!r}: expected its shape, got those of {', '.join(shapes) or 'none'}")
        each.type.tensor_type.shape.CopyFrom(_shape_proto(shapes[each.name]))
    for each in given.graph.output:
        each.type.tensor_type.ClearField("shape")
    found = onnx.shape_inference.infer_shapes(given, data_prop=True).graph
    known = dict(held)
    for value in (*found.value_info, *found.input, *found.output):
        sizes = value.type.tensor_type.shape.dim
        if value.type.tensor_type.HasField("shape") and all(size.HasField("dim_value") for size in sizes):
            known[value.name] = tuple(size.dim_value for size in sizes)
    return known


def _shape_proto(shape: Sequence[int]) -> Any:
    from onnx import TensorShapeProto

    return TensorShapeProto(dim=[TensorShapeProto.Dimension(dim_value=size) for size in shape])


def _conv(node: NodeProto, x: Shape, weight: Shape, y: Shape) -> int:
    """`weight` is (out, in / groups, *kernel): every output takes that many of its own."""
    return prod(y) * prod(weight[1:])


def _conv_transpose(node: NodeProto, x: Shape, weight: Shape, y: Shape) -> int:
    """`weight` is (in, out / groups, *kernel): every input is spread over that many."""
    return prod(x) * prod(weight[1:])


def _gemm(node: NodeProto, x: Shape, weight: Shape, y: Shape) -> int:
    across = any(attribute.name == "transA" and attribute.i for attribute in node.attribute)
    return prod(y) * x[0 if across else 1]


def _matmul(node: NodeProto, x: Shape, weight: Shape, y: Shape) -> int:
    return prod(y) * x[-1]


_COUNTS: dict[str, Callable[[NodeProto, Shape, Shape, Shape], int]] = {
    "Conv": _conv,
    "ConvTranspose": _conv_transpose,
    "Gemm": _gemm,
    "MatMul": _matmul,
}
