"""Convolutional networks written down as ONNX graphs node by node, batch normalisation folded into the weights."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import onnx

Weights = Mapping[str, NDArray[np.float32]]
OPSET = 18
IR_VERSION = 9


class GraphBuilder:
    """Collects nodes and constants; each method appends one layer to the tensor it is given and names the new one."""

    def __init__(self) -> None:
        self._nodes: list[Any] = []
        self._constants: list[Any] = []
        self._count = 0

    def node(self, operator: str, *inputs: str, **attributes: Any) -> str:
        """Append one operator and return its output's name."""
        from onnx import helper

        self._count += 1
        output = f"t{self._count}"
        self._nodes.append(helper.make_node(operator, list(inputs), [output], **attributes))
        return output

    def constant(self, values: NDArray[Any]) -> str:
        """Store an array in the graph and return its name."""
        from onnx import numpy_helper

        name = f"c{len(self._constants)}"
        self._constants.append(numpy_helper.from_array(np.ascontiguousarray(values), name))
        return name

    def convolution(self, x: str, weight: NDArray[np.float32], bias: NDArray[np.float32], **attributes: Any) -> str:
        """Convolution with `weight` (out, in / groups, kh, kw) and `bias` (out,)."""
        kernel = self.constant(weight.astype(np.float32))
        offset = self.constant(bias.astype(np.float32))
        return self.node("Conv", x, kernel, offset, kernel_shape=list(weight.shape[2:]), **attributes)

    def pixels(self, x: str, mean: NDArray[np.float32], scale: NDArray[np.float32]) -> str:
        """uint8 (N, H, W, 3) to float32 (N, 3, H, W), as (x - mean) * scale per channel."""
        from onnx import TensorProto

        x = self.node("Cast", x, to=TensorProto.FLOAT)
        x = self.node("Sub", x, self.constant(mean.astype(np.float32)))
        x = self.node("Mul", x, self.constant(scale.astype(np.float32)))
        return self.node("Transpose", x, perm=[0, 3, 1, 2])

    def resize(self, x: str, side: int) -> str:
        """Bilinear resize of (N, C, H, W) to (N, C, side, side), half-pixel centres."""
        sizes = self.constant(np.array([side, side], dtype=np.int64))
        return self.node("Resize", x, "", "", sizes, mode="linear", axes=[2, 3])

    def averaged(self, x: str, side: int, parts: int) -> str:
        """(N, C, H, W) resized to (N, C, side, side), then averaged over blocks to (N, C, parts, parts)."""
        step = side // parts
        return self.node("AveragePool", self.resize(x, side), kernel_shape=[step, step], strides=[step, step])

    def model(self, inputs: Mapping[str, tuple[int, list[Any]]], outputs: Mapping[str, tuple[str, list[Any]]]) -> bytes:
        """The checked model. `inputs`: name -> (element type, shape); `outputs`: name -> (tensor, shape)."""
        import onnx
        from onnx import TensorProto, helper

        ends = [helper.make_node("Identity", [tensor], [name]) for name, (tensor, _) in outputs.items()]
        graph = helper.make_graph(
            self._nodes + ends,
            "backbone",
            [helper.make_tensor_value_info(name, *kind) for name, kind in inputs.items()],
            [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, (_, shape) in outputs.items()],
            self._constants,
        )
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], producer_name="fusion")
        model.ir_version = IR_VERSION
        onnx.checker.check_model(model, full_check=True)
        return bytes(model.SerializeToString(deterministic=True))


def fold_batch_norm(
    weight: NDArray[np.float32], weights: Weights, norm: str, epsilon: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Weight and bias of a convolution that does the work of itself and the batch normalisation `norm` after it."""
    scale = weights[f"{norm}.weight"].astype(np.float64) / np.sqrt(
        weights[f"{norm}.running_var"].astype(np.float64) + epsilon
    )
    bias = weights[f"{norm}.bias"] - weights[f"{norm}.running_mean"] * scale
    return (weight * scale[:, None, None, None]).astype(np.float32), bias.astype(np.float32)


def only_output(model: onnx.ModelProto, name: str) -> onnx.ModelProto:
    """The model with the one output `name`, without nodes and constants that it does not need; KeyError without it."""
    import onnx

    kept = onnx.ModelProto()
    kept.CopyFrom(model)
    graph = kept.graph
    outputs = [value for value in graph.output if value.name == name]
    if not outputs:
        raise KeyError(name)
    needed, nodes = {name}, []
    for node in reversed(graph.node):
        if needed.intersection(node.output):
            nodes.append(node)
            needed.update(node.input)
    constants = [constant for constant in graph.initializer if constant.name in needed]
    for field, values in ((graph.output, outputs), (graph.node, nodes[::-1]), (graph.initializer, constants)):
        copies = [type(value).FromString(value.SerializeToString()) for value in values]
        del field[:]
        field.extend(copies)
    return kept
