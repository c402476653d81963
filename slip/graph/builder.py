"""Collects ONNX nodes; one description serves the batch graph and the stream graph of a detector."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from onnx import ModelProto, TensorProto, checker, helper, numpy_helper

Value = str | float | NDArray[Any]
OPSET = 18
IR_VERSION = 9


class Graph:
    """Nodes, constants and states of one graph, in double precision between the float32 ends.

    Tensors are named by strings and laid out (sequences, samples, ...). A batch graph takes whole sequences; a
    stream graph takes one sample of one sequence and carries what it needs of earlier ones in its states. The
    two differ in `past` alone: zeros there, a state here, and so a state of zeros is a fresh stream.
    """

    def __init__(self, stream: bool) -> None:
        self.stream = stream
        self._nodes: list[Any] = []
        self._constants: dict[tuple[Any, ...], str] = {}
        self._initializers: list[Any] = []
        self._inputs: list[Any] = []
        self._outputs: list[Any] = []
        self._count = 0

    def op(self, operator: str, *inputs: Value, **attributes: Any) -> str:
        """Append a node; a number becomes a double constant, an array one of its own type. Returns the output."""
        self._count += 1
        output = f"t{self._count}"
        names = [each if isinstance(each, str) else self.constant(each) for each in inputs]
        self._nodes.append(helper.make_node(operator, names, [output], **attributes))
        return output

    def input(self, name: str, element_type: int, shape: list[int | str]) -> str:
        """Declare an input of the graph."""
        self._inputs.append(helper.make_tensor_value_info(name, element_type, shape))
        return name

    def output(self, name: str, tensor: str, element_type: int, shape: list[int | str]) -> None:
        """Declare an output of the graph."""
        self._nodes.append(helper.make_node("Identity", [tensor], [name]))
        self._outputs.append(helper.make_tensor_value_info(name, element_type, shape))

    def past(self, values: str, count: int, width: tuple[int, ...], name: str) -> str:
        """Put the `count` samples before `values` (N, T, *width) in front of it; (N, count + T, *width).

        In a batch they are zeros. In a stream they are `state_<name>` (1, count, *width), which goes on as
        `state_<name>_out`.
        """
        if count == 0:
            return values
        if not self.stream:
            pads = np.zeros(2 * (2 + len(width)), dtype=np.int64)
            pads[1] = count
            return self.op("Pad", values, pads, 0.0)
        shape: list[int | str] = [1, count, *width]
        state = self.input(f"state_{name}", TensorProto.DOUBLE, shape)
        joined = self.op("Concat", state, values, axis=1)
        self.output(f"state_{name}_out", self.cut(joined, 1, -count), TensorProto.DOUBLE, shape)
        return joined

    def cut(self, values: str, axis: int, start: int, stop: int | None = None) -> str:
        """`values[start:stop]` along one axis."""
        end = np.iinfo(np.int64).max if stop is None else stop
        return self.op("Slice", values, integers(start), integers(end), integers(axis))

    def sum(self, values: str, axis: int, keep: bool = False) -> str:
        """Sum along one axis."""
        return self.op("ReduceSum", values, integers(axis), keepdims=int(keep))

    def max(self, values: str, axis: int) -> str:
        """Largest along one axis."""
        return self.op("ReduceMax", values, integers(axis), keepdims=0)

    def length(self, values: str, axis: int) -> str:
        """Extent of one axis, int64 of shape (1,)."""
        return self.op("Shape", values, start=axis, end=axis + 1)

    def double(self, values: str) -> str:
        """`values` in double precision."""
        return self.op("Cast", values, to=TensorProto.DOUBLE)

    def model(self, name: str) -> ModelProto:
        """Return the checked model."""
        graph = helper.make_graph(self._nodes, name, self._inputs, self._outputs, self._initializers)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], producer_name="slip")
        model.ir_version = IR_VERSION
        checker.check_model(model, full_check=True)
        return model

    def constant(self, value: float | NDArray[Any]) -> str:
        """Store a number, as double, or an array as it is, once; return its name."""
        array = np.ascontiguousarray(value) if isinstance(value, np.ndarray) else np.array(value, dtype=np.float64)
        key = (array.dtype.str, array.shape, array.tobytes())
        if key not in self._constants:
            self._constants[key] = f"c{len(self._constants)}"
            self._initializers.append(numpy_helper.from_array(array, self._constants[key]))
        return self._constants[key]


def integers(*values: int) -> NDArray[np.int64]:
    """int64 array of shape (len(values),), as the operators take axes, shapes and bounds."""
    return np.array(values, dtype=np.int64)


def add_metadata(model: ModelProto, entries: Mapping[str, str]) -> None:
    """Write text entries into the model's metadata."""
    helper.set_model_props(model, dict(entries))
