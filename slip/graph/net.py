"""A trained net as a graph: the convolutions over force differences and the head."""

from __future__ import annotations

import numpy as np

from slip.graph.builder import Graph
from slip.net import KERNEL, Net


def net_score(g: Graph, differences: str, held: str | None, net: Net) -> str:
    """`slip.net.Net.scores`: (N, T, taxels) and held embeddings (N, T, embedding), where there is a camera."""
    values = compress(g, differences)
    width = net.shape.taxels
    for level in range(net.shape.levels):
        out = g.op("Relu", convolve(g, values, f"conv{level}", 1 << level, width, net))
        values, width = (g.op("Add", values, out) if level else out), net.shape.channels
    joined = values if held is None else g.op("Concat", values, held, axis=2)
    logit = g.sum(linear(g, g.op("Relu", linear(g, joined, "hidden", net)), "slip", net), 2)  # of one value
    decay = g.op("Exp", g.op("Neg", g.op("Abs", logit)))
    return g.op("Add", g.op("Relu", logit), g.op("Log", g.op("Add", 1.0, decay)))


def convolve(g: Graph, values: str, name: str, dilation: int, width: int, net: Net) -> str:
    """The named causal convolution over axis 1 of (N, T, width)."""
    padded = g.past(values, (KERNEL - 1) * dilation, (width,), name)
    ends = [(tap + 1 - KERNEL) * dilation or None for tap in range(KERNEL)]
    rows = [g.cut(padded, 1, tap * dilation, end) for tap, end in enumerate(ends)]
    return linear(g, g.op("Concat", *rows, axis=2), name, net)


def linear(g: Graph, values: str, name: str, net: Net) -> str:
    """The named linear layer; its weights are kept as the float32 that they are."""
    weight, bias = (g.double(g.constant(net.weights[each].astype(np.float32))) for each in (name, f"{name}.bias"))
    return g.op("Add", g.op("MatMul", values, weight), bias)


def compress(g: Graph, values: str) -> str:
    """sign(x) log(1 + |x|)."""
    size = g.op("Log", g.op("Add", 1.0, g.op("Abs", values)))
    return g.op("Mul", g.op("Sign", values), size)
