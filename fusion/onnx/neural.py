"""Fusion nets: the same lines that predict with NumPy, run on values of a graph, record its nodes."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.onnx.builder import Graph, integers
from fusion.onnx.ends import between_two


def fusion_net(g: Graph, estimator: Any, x: str) -> str:
    """`fusion.neural.LateFusionNet` and `FusionTransformer`: logits, every modality there; of two classes, minus and
    plus half of the decision."""
    layout = estimator._net.layout
    parts = {}
    for part in layout.parts:
        columns = g.columns(x, np.array(part.columns), estimator.n_features_in_)
        scale = estimator._scales[part.name]
        flat = Value(g, columns, (-1, len(part.columns)))
        parts[part.name] = ((flat - scale.mean.ravel()) / scale.spread.ravel()).reshape(-1, *part.shape)
    logits: Value = estimator._net.logits(GraphOps(), estimator._weights, parts)
    return between_two(g, logits.name) if len(estimator.classes_) == 2 else logits.name


class Value:
    """A tensor of a graph, double, that computes as an array does; `shape` begins with -1, the rows."""

    __array_ufunc__ = None  # an array beside it leaves the operation to it

    def __init__(self, graph: Graph, name: str, shape: tuple[int, ...]) -> None:
        self.graph = graph
        self.name = name
        self.shape = shape

    def __add__(self, other: Value | NDArray[Any] | float) -> Value:
        return self._with("Add", other)

    def __sub__(self, other: Value | NDArray[Any] | float) -> Value:
        return self._with("Sub", other)

    def __mul__(self, other: Value | NDArray[Any] | float) -> Value:
        return self._with("Mul", other)

    def __truediv__(self, other: Value | NDArray[Any] | float) -> Value:
        return self._with("Div", other)

    def __pow__(self, exponent: float) -> Value:
        if exponent != 0.5:
            raise ValueError(f"only square roots are written, got the power {exponent}")
        return self._made(self.graph.op("Sqrt", self.name), self.shape)

    def __matmul__(self, other: Value | NDArray[Any]) -> Value:
        if isinstance(other, Value):
            return self._made(self.graph.op("MatMul", self.name, other.name), (*self.shape[:-1], other.shape[-1]))
        weights = np.asarray(other, np.float64)
        made = (
            self.graph.times(self.name, weights)
            if len(self.shape) == 2
            else self.graph.op("MatMul", self.name, weights)
        )
        return self._made(made, (*self.shape[:-1], weights.shape[-1]))

    def reshape(self, *shape: int) -> Value:
        """The same numbers in another shape; the first axis stays the rows."""
        if shape[0] != -1 or prod(shape[1:]) != prod(self.shape[1:]):
            raise ValueError(f"expected a shape of the rows and {prod(self.shape[1:])} numbers each, got {shape}")
        return self._made(self.graph.op("Reshape", self.name, integers(*shape)), shape)

    def swapaxes(self, first: int, second: int) -> Value:
        """Two axes exchanged."""
        order = list(range(len(self.shape)))
        order[first], order[second] = order[second], order[first]
        return self._made(self.graph.op("Transpose", self.name, perm=order), tuple(self.shape[i] for i in order))

    def mean(self, *, axis: int, keepdims: bool) -> Value:
        """Mean along the last axis, which stays with length 1."""
        if axis != -1 or not keepdims:
            raise ValueError(f"only means along the last axis are written, got axis={axis}, keepdims={keepdims}")
        return self._made(self.graph.op("ReduceMean", self.name, integers(-1), keepdims=1), (*self.shape[:-1], 1))

    def _with(self, operator: str, other: Value | NDArray[Any] | float) -> Value:
        shape = other.shape if isinstance(other, Value | np.ndarray) else ()
        beside = other.name if isinstance(other, Value) else np.asarray(other, np.float64)
        rest = np.broadcast_shapes(self.shape[1:], shape[1:] if len(shape) == len(self.shape) else shape)
        return self._made(self.graph.op(operator, self.name, beside), (-1, *rest))

    def _made(self, name: str, shape: tuple[int, ...]) -> Value:
        return Value(self.graph, name, shape)


class GraphOps:
    """`fusion.neural.ops.Ops` on values of a graph."""

    def relu(self, x: Value) -> Value:
        """max(x, 0)."""
        return Value(x.graph, x.graph.op("Relu", x.name), x.shape)

    def softmax(self, x: Value) -> Value:
        """Softmax over the last axis."""
        return Value(x.graph, x.graph.op("Softmax", x.name, axis=-1), x.shape)

    def concat(self, parts: Sequence[Value], axis: int) -> Value:
        """Values side by side along an axis."""
        length = sum(part.shape[axis] for part in parts)
        first = parts[0]
        name = first.name if len(parts) == 1 else first.graph.op("Concat", *(p.name for p in parts), axis=axis)
        return Value(first.graph, name, (*first.shape[:axis], length, *first.shape[axis + 1 :]))
