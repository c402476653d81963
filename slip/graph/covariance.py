"""The covariance detector as a graph: all windows of a sequence at once, or the window of a stream."""

from __future__ import annotations

import numpy as np

from slip.covariance import Covariance
from slip.graph.builder import Graph, integers
from slip.graph.windows import window_sum

LONGEST_TIME_WINDOW = 1_024
SHORTEST_TILE = 16


def covariance_score(g: Graph, differences: str, detector: Covariance, taxels: int) -> str:
    """`slip.covariance.Covariance`: (N, T, taxels) -> (N, T). Raises ValueError for too long a window in time.

    The time side holds every pair of its window: about 70 window bytes a sample in a batch, window^2 products a
    sample in a stream, which forms its Gram matrix anew and so carries no rounding on.
    """
    if detector.side == "time" and detector.window > LONGEST_TIME_WINDOW:
        raise ValueError(
            f"the time side of the covariance detector is exported for windows up to {LONGEST_TIME_WINDOW}, got "
            f'{detector.window}: its graph holds every pair of a window; take a shorter one or side="taxel"'
        )
    if g.stream:
        return _of_one_window(g, differences, detector, taxels)
    if detector.side == "taxel":
        return _taxel_side(g, differences, detector.window, taxels)
    return _time_side(g, differences, detector.window, taxels)


def _of_one_window(g: Graph, differences: str, detector: Covariance, taxels: int) -> str:
    rows = g.past(differences, detector.window - 1, (taxels,), "differences")
    columns = g.op("Transpose", rows, perm=[0, 2, 1])
    pair, side = ((rows, columns), detector.window) if detector.side == "time" else ((columns, rows), taxels)
    gram = g.op("Mul", g.op("Abs", g.op("MatMul", *pair)), 1.0 - np.eye(side))
    return g.op("Unsqueeze", g.max(g.sum(gram, 2), 1), integers(1))


def _taxel_side(g: Graph, differences: str, window: int, taxels: int) -> str:
    """Sum the products of each pair of taxels over each window."""
    first, second = np.triu_indices(taxels, 1)
    if len(first) == 0:
        return g.op("Mul", g.sum(differences, 2), 0.0)
    one, other = (g.op("Gather", differences, index, axis=2) for index in (first, second))
    cross = g.op("Abs", window_sum(g, g.op("Mul", one, other), window, (len(first),), "products"))
    member = np.zeros((len(first), taxels))
    member[np.arange(len(first)), first] = member[np.arange(len(first)), second] = 1.0
    return g.max(g.op("MatMul", cross, member), 2)


def _time_side(g: Graph, differences: str, window: int, taxels: int) -> str:
    """Rows of |d(i).d(j)| by lag j - i, tile by tile of samples; their sums for each window that holds i.

    From time t = i + k the row of sample i holds the lags k - window + 1 to k: a running sum outwards from the
    diagonal on either side of it. The score at t is the largest of them over k.
    """
    reach, tile = window - 1, max(window, SHORTEST_TILE)
    samples = g.length(differences, 1)
    tiles = g.op("Add", g.op("Div", samples, integers(tile)), integers(1))  # T < tiles * tile
    extra = g.op("Sub", g.op("Mul", tiles, integers(tile)), samples)
    # A tile of zeros before the sequence and one after it, beside what fills the last tile.
    pads = g.op("Concat", integers(0, tile, 0, 0), g.op("Add", extra, integers(tile)), integers(0), axis=0)
    rows = g.op("Reshape", g.op("Pad", differences, pads, 0.0), integers(0, -1, tile, taxels))
    before, own, after = g.cut(rows, 1, 0, -2), g.cut(rows, 1, 1, -1), g.cut(rows, 1, 2)
    around = g.op("Concat", g.cut(before, 2, tile - reach), own, g.cut(after, 2, 0, reach), axis=2)
    gram = g.op("Abs", g.op("MatMul", own, g.op("Transpose", around, perm=[0, 1, 3, 2])))
    by_lag = _diagonals(g, gram, tile, tile + 2 * reach)
    off_diagonal = np.ones(2 * reach + 1)
    off_diagonal[reach] = 0.0
    by_lag = g.op("Mul", g.cut(by_lag, 3, 0, 2 * reach + 1), off_diagonal)
    past = g.op("CumSum", g.cut(by_lag, 3, 0, window), np.array(3), reverse=1)
    future = g.op("CumSum", g.cut(by_lag, 3, reach), np.array(3))
    row_sums = g.op("Reshape", g.op("Add", past, future), integers(0, -1, window))
    return g.max(_seen_from(g, row_sums, window, samples), 1)


def _diagonals(g: Graph, gram: str, rows: int, columns: int) -> str:
    """Shift row r of (N, tiles, rows, columns) left by r: a column longer, the same numbers fall diagonally."""
    flat = g.op("Reshape", gram, integers(0, 0, rows * columns))
    flat = g.op("Pad", flat, integers(0, 0, 0, 0, 0, rows), 0.0)
    return g.op("Reshape", flat, integers(0, 0, rows, columns + 1))


def _seen_from(g: Graph, row_sums: str, window: int, samples: str) -> str:
    """From R[i, k] of (N, T', window), T' > T, take S[k, t] = R[t - k, k], 0 before the start; (N, window, T)."""
    by_delay = g.op("Transpose", row_sums, perm=[0, 2, 1])
    by_delay = g.op("Pad", by_delay, integers(0, 0, window, 0, 0, 0), 0.0)
    flat = g.op("Reshape", by_delay, integers(0, -1))
    flat = g.cut(flat, 1, 0, -window)
    shifted = g.cut(g.op("Reshape", flat, integers(0, window, -1)), 2, window)
    return g.op("Slice", shifted, integers(0), samples, integers(2))
