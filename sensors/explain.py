"""What a scene pays for: each effect on or off, its share of the time, and the error that leaving it out causes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

REPEATS = 3
"""Runs of each sample with and without an effect; the fastest of each counts."""


@dataclass(frozen=True)
class Readings:
    """What a run gave: forces (t, taxels) in newtons, frames (..., 3) in grey levels, surface (n, n) in metres."""

    force: NDArray[np.floating]
    frame: NDArray[Any] | None = None
    surface: NDArray[np.floating] | None = None


@dataclass(frozen=True)
class Effect:
    """One effect: on or off and why, its share of the time, and what changes when it is switched (None: unmeasured).

    `time_share` is of the scene's time: what an effect that is on takes, and what one that is off would add. `force_n`
    is the RMS over time of the taxel that changes most, `frame_levels` the RMS over the frame, `surface_um` the largest
    over the surface that the camera sees; means over the samples.
    """

    name: str
    on: bool
    why: str
    time_share: float | None = None
    force_n: float | None = None
    frame_levels: float | None = None
    surface_um: float | None = None


@dataclass(frozen=True)
class Grid:
    """A contact grid with its measured errors and bounds, by name; the errors are None where nothing was measured.

    An error is that of the worst class of objects, which `worst` names; half of the classes are within `median`.
    """

    model: str
    grid: int
    taken: bool
    error: dict[str, float] | None
    bound: dict[str, float]
    cost_ms: float | None
    worst: dict[str, str] = field(default_factory=dict)
    median: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Explanation:
    """A scene's effects, stages of a sample (CPU ms), contact models and grids that it could take, and why those."""

    scene: str
    samples: int
    cpu_ms: float
    effects: tuple[Effect, ...]
    stages_ms: dict[str, float] = field(default_factory=dict)
    grids: tuple[Grid, ...] = ()
    models: str = ""


Run = Callable[[int], Readings]
"""Runs sample `index` of a scene."""


@dataclass(frozen=True)
class Switch:
    """An effect, and the run of the same scene with it switched; None where `effect` is already measured.

    `base` is what to compare it with where the effect cannot be switched in the scene as it is.
    """

    effect: Effect
    run: Run | None = None
    base: Run | None = None


def measure_switches(
    base: Run, switches: Sequence[Switch], indices: Sequence[int], advance: Callable[[int], None]
) -> tuple[float, list[Effect]]:
    """CPU ms of a sample, and each effect measured on the samples `indices`; `advance` gets 1 an effect."""
    before = [_fastest(base, i) for i in indices]
    whole = sum(ms for ms, _ in before)
    measured = []
    for switch in switches:
        if switch.run is None:
            measured.append(switch.effect)
        elif switch.base is not None:
            others = [switch.base(i) for i in indices]
            measured.append(_switched(switch.effect, switch.base, switch.run, indices, others))
        else:
            measured.append(_switched(switch.effect, base, switch.run, indices, [one for _, one in before]))
        advance(1)
    return whole / len(indices), measured


def _switched(effect: Effect, base: Run, switched: Run, indices: Sequence[int], before: list[Readings]) -> Effect:
    with_ms = without_ms = 0.0
    force, frame, surface = [], [], []
    for i, own in zip(indices, before, strict=True):
        # side by side, so that a busy machine slows both
        pairs = [(_timed(base, i), _timed(switched, i)) for _ in range(REPEATS)]
        with_ms += min(pair[0][0] for pair in pairs)
        without_ms += min(pair[1][0] for pair in pairs)
        other = pairs[-1][1][1]
        force.append(float(np.sqrt(np.mean((own.force - other.force) ** 2, axis=0, dtype=np.float64)).max()))
        if own.frame is not None and other.frame is not None:
            frame.append(rms(own.frame.astype(np.float64) - other.frame))
        if own.surface is not None and other.surface is not None:
            surface.append(float(np.abs(own.surface - other.surface).max()) * 1e6)
    share = (with_ms - without_ms) / with_ms
    return Effect(
        effect.name, effect.on, effect.why, share if effect.on else -share, *map(_mean, (force, frame, surface))
    )


def rms(values: NDArray[Any]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64))))


def _mean(values: list[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _timed(run: Run, index: int) -> tuple[float, Readings]:
    start = time.process_time()
    result = run(index)
    return 1e3 * (time.process_time() - start), result


def _fastest(run: Run, index: int) -> tuple[float, Readings]:
    timed = [_timed(run, index) for _ in range(REPEATS)]
    return min(ms for ms, _ in timed), timed[-1][1]
