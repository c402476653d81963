"""From force readings to treated differences in a graph, and where a missing reading still counts."""

from __future__ import annotations

import numpy as np
from onnx import TensorProto

from slip.detector import DifferenceDetector
from slip.differences import RATIO_FLOOR_N
from slip.graph.builder import Graph
from slip.graph.windows import window_sum
from slip.samples import FORCE_LIMIT_N


def force_input(g: Graph, taxels: int) -> str:
    """Declare the forces as the file's contract names them; return them as (N, T, taxels), double."""
    if g.stream:
        force = g.input("force", TensorProto.FLOAT, [1, taxels])
        return g.op("Unsqueeze", g.double(force), np.array([0]))
    return g.double(g.input("force_series", TensorProto.FLOAT, ["N", "T", taxels]))


def score_output(g: Graph, score: str, missing: str) -> None:
    """Declare `slip_score`: (N, T) float32, NaN wherever a reading that is missing has a part in it."""
    told = g.op("Where", missing, np.array(np.nan), score)
    shape: list[int | str] = [1, 1] if g.stream else ["N", "T"]
    g.output("slip_score", g.op("Cast", told, to=TensorProto.FLOAT), TensorProto.FLOAT, shape)


def differences(g: Graph, force: str, detector: DifferenceDetector, taxels: int) -> tuple[str, str]:
    """Return the detector's treated differences (N, T, taxels) and a mask (N, T) of the scores they leave open.

    A sample with a reading that is not finite is left out of both its differences, which become 0 so that
    nothing else carries it on; the mask holds from it until it has left everything the score is made of.
    """
    within = g.op("LessOrEqual", g.op("Abs", force), FORCE_LIMIT_N)  # false for NaN
    usable = g.op("ReduceMin", g.double(within), np.array([2]), keepdims=1)
    force = g.op("Where", g.op("Cast", usable, to=TensorProto.BOOL), force, 0.0)
    previous = g.cut(g.past(force, 1, (taxels,), "force"), 1, 0, -1)
    usable_before = g.cut(g.past(usable, 1, (1,), "usable"), 1, 0, -1)  # 0 before the first sample
    treated = treat(g, g.op("Sub", force, previous), previous, detector.common_mode, taxels)
    if detector.scale is not None:
        treated = g.op("Div", treated, detector.scale)
    treated = g.op("Mul", treated, g.op("Mul", usable, usable_before))
    unusable = g.sum(g.op("Sub", 1.0, usable), 2)
    missing = g.op("Greater", window_sum(g, unusable, detector.settling, (), "unusable"), 0.0)
    return treated, missing


def treat(g: Graph, difference: str, previous: str, common_mode: str, taxels: int) -> str:
    """`slip.differences.treat`, operation by operation."""
    if common_mode == "mean":
        return g.op("Sub", difference, g.op("Div", g.sum(difference, 2, keep=True), float(taxels)))
    if common_mode == "load":
        energy = g.sum(g.op("Mul", previous, previous), 2, keep=True)
        along = g.sum(g.op("Mul", previous, difference), 2, keep=True)
        loaded = g.op("Greater", energy, 0.0)
        share = g.op("Where", loaded, g.op("Div", along, g.op("Where", loaded, energy, 1.0)), 0.0)
        return g.op("Sub", difference, g.op("Mul", share, previous))
    if common_mode == "ratio":
        change = g.op("Abs", g.sum(difference, 2, keep=True))
        return g.op("Div", difference, g.op("Add", change, RATIO_FLOOR_N))
    return difference
