"""Errors and speed of a reduced pad against the full one it was trained from, at depths that it has not seen."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from sensors.contact.neohookean.pad import NeoHookeanPad
from sensors.contact.neohookean.solution import PadSolution
from sensors.contact.neohookean.surface import Surface
from sensors.contact.neohookean_reduced.pad import ReducedPad

Floats = NDArray[np.float64]
T = TypeVar("T")


@dataclass(frozen=True)
class Comparison:
    """Per unseen depth (m): forces (N) of both, relative displacement error of the top, CPU (ms) of both a step."""

    depths_m: Floats
    full_n: Floats
    reduced_n: Floats
    displacement_error: Floats
    full_ms: float
    reduced_ms: float

    @property
    def force_error(self) -> Floats:
        """Signed, relative."""
        return self.reduced_n / self.full_n - 1


def compare(full: NeoHookeanPad, reduced: ReducedPad, surface: Surface, repeats: int = 3) -> Comparison:
    """Press both to the depths halfway between the trained ones, from the first trained depth on."""
    known = reduced.trained.depths_m
    depths = (known[1:-1] + known[2:]) / 2
    exact, full_ms = _timed(lambda: list(full.press_depths(surface, depths)))
    runs = [_timed(lambda: list(reduced.press_depths(surface, depths))) for _ in range(repeats)]
    replay = runs[0][0]
    return Comparison(
        depths,
        np.array([press.force_n for press in exact]),
        np.array([press.force_n for press in replay]),
        np.array([top_error(one, other) for one, other in zip(replay, exact, strict=True)]),
        full_ms / len(depths),
        float(np.median([ms for _, ms in runs])) / len(depths),
    )


def top_error(one: PadSolution, reference: PadSolution) -> float:
    """Root mean square difference of the top's displacement vectors over the reference's own, by area."""
    top, area = reference.mesh.top, reference.mesh.top_area[:, None]
    difference = (area * (one.displacement - reference.displacement)[top] ** 2).sum()
    return float(np.sqrt(difference / (area * reference.displacement[top] ** 2).sum()))


def _timed(work: Callable[[], T]) -> tuple[T, float]:
    start = time.process_time()
    out = work()
    return out, 1e3 * (time.process_time() - start)
