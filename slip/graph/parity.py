"""How far a graph's scores are from those of the detector it was made of."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from slip.samples import Floats

RELATIVE_TOLERANCE = 1e-6  # float32 scores are good to 6e-8


@dataclass(frozen=True)
class Parity:
    """What was measured on the check sequence when a graph was exported.

    largest_difference : between a score of the graph and the detector's, in the unit of the score.
    relative_difference : the largest of them over the largest score of the last two windows.
    samples : scores compared; onnxruntime : version that ran the graph.
    """

    largest_difference: float
    relative_difference: float
    samples: int
    onnxruntime: str

    def to_dict(self) -> dict[str, float | int | str]:
        """The report as it stands in the file's metadata."""
        return asdict(self)


def compare(graph: Floats, detector: Floats, settling: int, version: str) -> Parity:
    """Compare two scores (T,) of one sequence; raise ValueError where they differ by more than float32 explains."""
    apart = np.abs(graph - detector)
    padded = np.concatenate([np.zeros(2 * settling - 1), np.abs(detector)])
    recent = np.lib.stride_tricks.sliding_window_view(padded, 2 * settling).max(axis=1)
    smallest = float(np.finfo(np.float32).tiny)  # below it float32 holds no full precision
    relative = float((apart / np.maximum(recent, smallest)).max(initial=0.0))
    if not relative <= RELATIVE_TOLERANCE:
        raise ValueError(
            f"the graph's scores differ from the detector's by {relative:.3g} of the largest score of two windows, "
            f"more than {RELATIVE_TOLERANCE:g}: no file was written"
        )
    return Parity(float(apart.max(initial=0.0)), relative, len(detector), version)


def check_force(settling: int, taxels: int) -> Floats:
    """Forces (T, taxels) in newtons that stir a detector: rest, a load that rises, a burst, rest; float32 values."""
    rng = np.random.default_rng(0)
    part = settling // 2 + 60
    load = np.concatenate([np.full(part, 0.5), np.linspace(0.5, 3.0, part), np.full(2 * part, 3.0)])
    force = load[:, None] * rng.uniform(0.2, 1.0, taxels) + 1e-3 * rng.standard_normal((4 * part, taxels))
    force[2 * part : 3 * part] += 0.05 * rng.standard_normal((part, taxels))
    return force.astype(np.float32).astype(np.float64)
