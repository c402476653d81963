"""Sliding sums in a graph, by doubling as in `slip.windows`: nothing is subtracted."""

from __future__ import annotations

from slip.graph.builder import Graph


def window_sum(g: Graph, values: str, window: int, width: tuple[int, ...], name: str) -> str:
    """Sum over the last `window` samples of (N, T, *width), fewer at the start; `name` is of the state it takes."""
    power = g.past(values, window - 1, width, name)
    total, length, offset = "", 1, 0
    while True:
        if window & length:
            # What is left after this part reaches `window - offset - length` samples beyond it.
            left = window - offset - length
            part = g.cut(power, 1, offset, -left if left else None)
            total = g.op("Add", total, part) if total else part
            offset += length
        if 2 * length > window:
            return total
        power = g.op("Add", g.cut(power, 1, 0, -length), g.cut(power, 1, length))
        length *= 2
