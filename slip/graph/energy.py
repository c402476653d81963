"""The energy baseline and the high-band energy as graphs."""

from __future__ import annotations

from slip.energy import Energy
from slip.graph.builder import Graph
from slip.graph.windows import window_sum
from slip.spectral import Spectral


def energy_score(g: Graph, differences: str, detector: Energy, taxels: int) -> str:
    """`slip.energy.Energy`: (N, T, taxels) -> (N, T)."""
    moved = g.sum(g.op("Abs", differences), 2)
    return g.op("Div", window_sum(g, moved, detector.window, (), "moved"), float(detector.window * taxels))


def spectral_score(g: Graph, differences: str, detector: Spectral, taxels: int) -> str:
    """`slip.spectral.Spectral`: (N, T, taxels) -> (N, T)."""
    taps = len(detector.coefficients)
    padded = g.past(differences, taps - 1, (taxels,), "differences")
    shifted = [g.cut(padded, 1, tap, tap + 1 - taps or None) for tap in range(taps)]
    parts = [g.op("Mul", part, float(c)) for part, c in zip(shifted, detector.coefficients, strict=True)]
    high = g.op("Sum", *parts)
    energy = g.sum(g.op("Mul", high, high), 2)
    return g.op("Div", window_sum(g, energy, detector.window, (), "energy"), float(detector.window * taxels))
