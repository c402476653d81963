"""Collects ONNX nodes of a pipeline; plain `ai.onnx` operators, checked when the model is made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from onnx import ModelProto, TensorProto, checker, compose, helper, numpy_helper, version_converter

Value = str | float | NDArray[Any]
OPSET = 18
IR_VERSION = 9
STANDARD_DOMAINS = ("", "ai.onnx", "ai.onnx.ml")


class Graph:
    """Nodes, constants, inputs and outputs of one graph; tensors are named by strings."""

    def __init__(self) -> None:
        self._nodes: list[Any] = []
        self._names: dict[tuple[Any, ...], str] = {}
        self._initializers: list[Any] = []
        self._inputs: dict[str, Any] = {}
        self._outputs: list[Any] = []
        self._opsets = {"": OPSET}
        self._count = 0

    def op(self, operator: str, *inputs: Value, **attributes: Any) -> str:
        """Append a node; a number becomes a double constant, an array one of its own type. Returns the output."""
        self._count += 1
        output = f"t{self._count}"
        names = [each if isinstance(each, str) else self.constant(each) for each in inputs]
        self._nodes.append(helper.make_node(operator, names, [output], **attributes))
        return output

    def top(self, values: str, count: int) -> tuple[str, str]:
        """The `count` smallest of each row (N, n), ascending, and where they stand; equal ones by lowest place."""
        self._count += 1
        outputs = [f"t{self._count}", f"t{self._count}i"]
        node = helper.make_node("TopK", [values, self.constant(integers(count))], outputs, axis=1, largest=0, sorted=1)
        self._nodes.append(node)
        return outputs[0], outputs[1]

    def input(self, name: str, element_type: int, shape: list[int | str]) -> str:
        """Declare an input of the graph, once."""
        self._inputs.setdefault(name, helper.make_tensor_value_info(name, element_type, shape))
        return name

    def output(self, name: str, tensor: str, shape: list[int | str]) -> None:
        """Declare a float32 output of the graph."""
        self._nodes.append(helper.make_node("Identity", [tensor], [name]))
        self._outputs.append(helper.make_tensor_value_info(name, TensorProto.FLOAT, shape))

    def constant(self, value: float | NDArray[Any]) -> str:
        """Store a number, as double, or an array as it is, once; return its name."""
        array = np.ascontiguousarray(value) if isinstance(value, np.ndarray) else np.array(value, dtype=np.float64)
        key = (array.dtype.str, array.shape, array.tobytes())
        if key not in self._names:
            self._names[key] = f"c{len(self._names)}"
            self._initializers.append(numpy_helper.from_array(array, self._names[key]))
        return self._names[key]

    def double(self, x: str) -> str:
        """`x` in double precision."""
        return self.op("Cast", x, to=TensorProto.DOUBLE)

    def sum(self, x: str, axis: int, keep: bool = False) -> str:
        """Sum along one axis."""
        return self.op("ReduceSum", x, integers(axis), keepdims=int(keep))

    def every(self, *conditions: str) -> str:
        """Whether all of several masks of one shape hold."""
        first, *others = conditions
        for other in others:
            first = self.op("And", first, other)
        return first

    def times(self, x: str, matrix: NDArray[np.float64]) -> str:
        """Rows of x (N, d) times a matrix (d, p), one product a row: no row depends on how many there are."""
        row = self.op("MatMul", self.op("Unsqueeze", x, integers(1)), matrix)
        return self.op("Squeeze", row, integers(1))

    def columns(self, x: str, chosen: slice | NDArray[np.int64], width: int) -> str:
        """Some columns of x (N, width)."""
        numbers = np.arange(width)[chosen] if isinstance(chosen, slice) else np.asarray(chosen, dtype=np.int64)
        return x if np.array_equal(numbers, np.arange(width)) else self.op("Gather", x, numbers, axis=1)

    def include(self, model: ModelProto, inputs: Mapping[str, str], output: str) -> str:
        """Append a whole model: its inputs by name -> tensors of this graph; returns the tensor of one output.

        Raises:
            ValueError: operators of domains that are not standard, or functions of the model's own.
        """
        if model.functions:
            raise ValueError("a model with functions of its own cannot be merged; inline them first")
        versions = {each.domain: each.version for each in model.opset_import}
        for domain, version in versions.items():
            if domain not in STANDARD_DOMAINS:
                raise ValueError(f"a model with operators of the domain {domain!r} is not portable")
            if domain not in ("", "ai.onnx"):
                self._opsets[domain] = max(version, self._opsets.get(domain, 0))
        if versions.get("", versions.get("ai.onnx", OPSET)) != OPSET:
            model = version_converter.convert_version(model, OPSET)
        self._count += 1
        prefix = f"m{self._count}_"
        part = compose.add_prefix(model, prefix).graph
        self._nodes += [helper.make_node("Identity", [inputs[name]], [prefix + name]) for name in inputs]
        self._nodes += part.node
        self._initializers += part.initializer
        return prefix + output

    def model(self, name: str) -> ModelProto:
        """The checked model."""
        graph = helper.make_graph(self._nodes, name, list(self._inputs.values()), self._outputs, self._initializers)
        opsets = [helper.make_opsetid(domain, version) for domain, version in self._opsets.items()]
        model = helper.make_model(graph, opset_imports=opsets, producer_name="fusion")
        model.ir_version = IR_VERSION
        checker.check_model(model, full_check=True)
        return model


def integers(*values: int) -> NDArray[np.int64]:
    """int64 array of shape (len(values),), as the operators take axes, shapes and bounds."""
    return np.array(values, dtype=np.int64)
