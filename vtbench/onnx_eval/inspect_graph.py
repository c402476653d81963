"""Bytes of a model -> what it is made of, and what in it is refused. Runs where the model's own process is locked."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import onnx

from vtbench.onnx_eval.contract import Axis, Port

DOMAINS = ("", "ai.onnx", "ai.onnx.ml")
"""Operators of the standard; every other domain needs code that is not in the file."""
EXPORT_KEY = "vtbench"
_SHOWN = 40
_MOST_METADATA = 100_000


@dataclass(frozen=True)
class Graph:
    """Inputs without those that have a default, outputs, sizes, and what the file says that it was fitted on."""

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    parameters: int
    nodes: int
    fitted_on: dict[str, str]


def read(content: bytes) -> tuple[Graph, list[str]]:
    """Return a model's graph and one line for each thing in it that is refused.

    Raises:
        ValueError: bytes that are no ONNX model.
    """
    model = onnx.ModelProto()
    try:
        model.ParseFromString(content)
    except Exception as error:
        raise ValueError(f"no ONNX model: {type(error).__name__}; the file is truncated or something else") from None
    if not model.graph.node and not model.graph.output:
        raise ValueError("no ONNX model: it holds no graph; the file is truncated or something else")
    nodes = list(_nodes(model.graph.node))
    own = {(function.domain, function.name): function for function in model.functions}
    for function in model.functions:
        nodes += _nodes(function.node)
    tensors = list(_tensors(model, nodes))
    refused = [*_operators(nodes, own), *_outside(tensors), *_recursive(own)]
    constants = {each.name for each in model.graph.initializer} | {
        each.values.name for each in model.graph.sparse_initializer
    }
    graph = Graph(
        tuple(_port(value) for value in model.graph.input if value.name not in constants),
        tuple(_port(value) for value in model.graph.output),
        sum(_size(tensor) for tensor in model.graph.initializer),
        len(nodes),
        _fitted_on(model),
    )
    return graph, refused


def _fitted_on(model: Any) -> dict[str, str]:
    """Dataset, variant, split, fold and seed, as `vtbench export` writes them; empty without, or for nonsense."""
    for entry in model.metadata_props:
        if entry.key != EXPORT_KEY or len(entry.value) > _MOST_METADATA:
            continue
        try:
            said = json.loads(entry.value)
            if said.get("learns") is False:
                return {}
            found = {name: said[name] for name in ("dataset_hash", "variant", "split")}
            found |= {name: said["fit"][name] for name in ("fold", "seed")}
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            return {}
        return {name: shown(str(value)) if name != "dataset_hash" else str(value)[:64] for name, value in found.items()}
    return {}


def shown(text: str) -> str:
    """A name out of a model, safe to print: 40 visible ASCII characters at most, the rest as '?'."""
    safe = "".join(letter if "!" <= letter <= "~" or letter == " " else "?" for letter in text[:_SHOWN])
    return safe + ("..." if len(text) > _SHOWN else "")


def _nodes(nodes: Sequence[Any]) -> Iterator[Any]:
    """Every node, those inside the branches and loops of others included."""
    left = list(nodes)
    while left:
        node = left.pop()
        yield node
        for graph in _subgraphs(node):
            left += graph.node


def _subgraphs(node: Any) -> Iterator[Any]:
    for attribute in node.attribute:
        if attribute.HasField("g"):
            yield attribute.g
        yield from attribute.graphs


def _tensors(model: Any, nodes: Sequence[Any]) -> Iterator[Any]:
    for graph in [model.graph, *(graph for node in nodes for graph in _subgraphs(node))]:
        yield from graph.initializer
        for sparse in graph.sparse_initializer:
            yield from (sparse.values, sparse.indices)
    holders = [*nodes, *model.functions]
    for holder in holders:
        attributes = holder.attribute if hasattr(holder, "op_type") else holder.attribute_proto
        for attribute in attributes:
            sparse = [
                *attribute.sparse_tensors,
                *([attribute.sparse_tensor] if attribute.HasField("sparse_tensor") else []),
            ]
            yield from attribute.tensors
            if attribute.HasField("t"):
                yield attribute.t
            for each in sparse:
                yield from (each.values, each.indices)


def _operators(nodes: Sequence[Any], own: dict[tuple[str, str], Any]) -> Iterator[str]:
    strange = {
        f"{shown(node.domain)}.{shown(node.op_type)}"
        for node in nodes
        if node.domain not in DOMAINS and (node.domain, node.op_type) not in own
    }
    for name in sorted(strange)[:5]:
        yield f"operator {name}: expected operators of ai.onnx and ai.onnx.ml alone; export without custom operators"


def _outside(tensors: Sequence[Any]) -> Iterator[str]:
    outside = [
        tensor for tensor in tensors if tensor.external_data or tensor.data_location == onnx.TensorProto.EXTERNAL
    ]
    if outside:
        where = {entry.key: entry.value for entry in outside[0].external_data}.get("location", "nowhere")
        yield (
            f"tensor {shown(outside[0].name)!r} lies outside the file, in {shown(where)!r}: expected one file "
            "that holds all weights; save the model without external data"
        )


def _recursive(own: dict[tuple[str, str], Any]) -> Iterator[str]:
    """Functions that call themselves, by way of others too."""
    calls = {
        name: {call for node in _nodes(function.node) if (call := (node.domain, node.op_type)) in own}
        for name, function in own.items()
    }
    left = dict(calls)
    while leaves := [name for name, called in left.items() if not called & left.keys()]:
        for name in leaves:
            del left[name]
    if left:
        first = shown(next(iter(left))[1])
        yield f"function {first!r} calls itself: expected functions without recursion"


def _port(value: Any) -> Port:
    kind = value.type.tensor_type
    if not value.type.HasField("tensor_type"):
        return Port(shown(value.name), "something that is no tensor", None)
    names = {number: name.lower() for name, number in onnx.TensorProto.DataType.items()}
    dtype = {"float": "float32", "double": "float64"}.get(found := names.get(kind.elem_type, "unknown"), found)
    shape = tuple(_axis(axis) for axis in kind.shape.dim) if kind.HasField("shape") else None
    return Port(shown(value.name), dtype, shape)


def _axis(axis: Any) -> Axis:
    if axis.HasField("dim_value") and axis.dim_value > 0:
        return int(axis.dim_value)
    return None


def _size(tensor: Any) -> int:
    size = 1
    for length in tensor.dims:
        size *= max(int(length), 0)
    return min(size, 2**62)
