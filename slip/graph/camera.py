"""The camera's part of a net as a graph.

A batch takes `frames` (N, F, H, W, 3) uint8 and `frame_samples` (N, F) int64, the force sample that each came with,
rising; one at or beyond T is never seen, so that sequences with fewer frames can be filled up. A stream takes `frame`
(0 or 1, H, W, 3): no frame, or the one that came with this sample.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from onnx import TensorProto

from slip.graph.builder import Graph, integers
from slip.graph.net import compress, convolve, linear
from slip.net import Net
from slip.net_camera import edges


def held_embedding(g: Graph, force: str, net: Net, height: int, width: int) -> str:
    """Declare the frames; return the embedding that holds at each sample of force (N, T, taxels); (N, T, E)."""
    if g.stream:
        frame = g.input("frame", TensorProto.UINT8, ["F", height, width, 3])
        told = _embed(g, g.op("Unsqueeze", frame, integers(0)), net, height, width)
        return g.cut(g.past(told, 1, (net.shape.embedding,), "embedding"), 1, -1)
    frames = g.input("frames", TensorProto.UINT8, ["N", "F", height, width, 3])
    at = g.input("frame_samples", TensorProto.INT64, ["N", "F"])
    told = g.past(_embed(g, frames, net, height, width), 1, (net.shape.embedding,), "embedding")
    there = _frames_there(g, force, at)
    index = g.op("Expand", g.op("Unsqueeze", there, integers(2)), integers(1, 1, net.shape.embedding))
    return g.op("GatherElements", told, index, axis=1)


def _embed(g: Graph, frames: str, net: Net, height: int, width: int) -> str:
    """Embeddings (N, F, embedding) of frames (N, F, H, W, 3)."""
    shape = net.shape
    side, patch = shape.grid // shape.patch, shape.patch
    change = compress(g, g.op("Div", _change(g, frames, shape.grid, height, width), net.frame_scale))
    cut = g.op("Reshape", change, integers(0, 0, side, patch, side, patch, 3))
    cut = g.op("Transpose", cut, perm=[0, 1, 2, 4, 3, 5, 6])
    cut = g.op("Reshape", cut, integers(0, 0, shape.cells, patch * patch * 3))
    seen = g.op("Relu", linear(g, cut, "patch", net))
    told = g.op("Reshape", seen, integers(0, 0, shape.cells * shape.patch_features))
    return g.op("Relu", convolve(g, told, "motion", 1, shape.cells * shape.patch_features, net))


def _change(g: Graph, frames: str, grid: int, height: int, width: int) -> str:
    """Change of each downsampled frame from the one before it, 0 for the first; (N, F, grid, grid, 3)."""
    small = _downsample(g, frames, grid, height, width)
    every = g.op("Concat", g.length(frames, 0), g.length(frames, 1), integers(1, 1, 1), axis=0)
    before = g.cut(g.past(small, 1, (grid, grid, 3), "frame"), 1, 0, -1)
    seen = g.cut(g.past(g.op("Expand", 1.0, every), 1, (1, 1, 1), "frame_seen"), 1, 0, -1)
    return g.op("Mul", g.op("Sub", small, before), seen)


def _downsample(g: Graph, frames: str, grid: int, height: int, width: int) -> str:
    """Mean of each cell; its sum is a whole number, exact in float32 unless the cell is huge."""
    rows, columns = (edges(pixels, grid) for pixels in (height, width))
    pixels = np.diff(rows)[:, None, None] * np.diff(columns)[None, :, None]
    exact = 255 * int(pixels.max()) < 2**24
    values = g.op("Cast", frames, to=TensorProto.FLOAT if exact else TensorProto.DOUBLE)
    sums = _sum_runs(g, _sum_runs(g, values, 2, rows), 3, columns)
    return g.op("Div", g.double(sums), pixels.astype(np.float64))


def _sum_runs(g: Graph, values: str, axis: int, ends: NDArray[np.intp]) -> str:
    """Sum each run of pixels along one axis. By slices: a product fails on a stack of no frames."""
    runs = [g.cut(values, axis, int(start), int(stop)) for start, stop in pairwise(ends)]
    return g.op("Concat", *(g.sum(run, axis, keep=True) for run in runs), axis=axis)


def _frames_there(g: Graph, force: str, at: str) -> str:
    """Number of frames (N, T) that are there at each sample."""
    samples = g.length(force, 1)
    counted = g.op("Concat", g.length(force, 0), g.op("Add", samples, integers(1)), axis=0)
    nothing = g.op("Expand", integers(0), counted)
    one = g.op("Expand", integers(1), g.op("Shape", at))
    come = g.op("ScatterElements", nothing, g.op("Min", at, samples), one, axis=1, reduction="add")
    return g.cut(g.op("CumSum", come, np.array(1)), 1, 0, -1)
