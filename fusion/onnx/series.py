"""Recordings of any length as means over a fixed number of equal parts, in a graph."""

from __future__ import annotations

import numpy as np

from fusion.onnx.builder import Graph, integers


def step_means(g: Graph, series: str, steps: int) -> str:
    """Means of series (N, T, channels), double, over `steps` equal parts of its samples: (N, steps x channels).

    A part that begins or ends within a sample takes its share of it.
    """
    length = g.op("Shape", series, start=1, end=2)
    samples = g.double(length)
    running = g.op("CumSum", series, np.array(1))
    start = g.op("Mul", g.op("Slice", series, integers(0), integers(1), integers(1)), 0.0)
    total = g.op("Concat", start, running, axis=1)
    edges = g.op("Mul", np.arange(steps + 1, dtype=np.float64), g.op("Div", samples, float(steps)))
    whole = g.op("Min", g.op("Cast", g.op("Floor", edges), to=7), g.op("Sub", length, integers(1)))
    part = g.op("Unsqueeze", g.op("Sub", edges, g.double(whole)), integers(1))
    before = g.op("Gather", total, whole, axis=1)
    after = g.op("Gather", total, g.op("Add", whole, integers(1)), axis=1)
    upto = g.op("Add", before, g.op("Mul", part, g.op("Sub", after, before)))
    late = g.op("Slice", upto, integers(1), integers(steps + 1), integers(1))
    early = g.op("Slice", upto, integers(0), integers(steps), integers(1))
    means = g.op("Mul", g.op("Sub", late, early), g.op("Div", float(steps), samples))
    return g.op("Flatten", means, axis=1)
