"""A test set that nobody has seen: sensors, presses and noise drawn from a seed that is committed to, not told.

The seed moves the whole protocol on to sensor units far beyond those of any suite, and draws everything else anew.
What is published is a commitment, the SHA-256 of seed and scene: once the seed is told, anyone can make the set again.
"""

from __future__ import annotations

import hashlib
import os
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vtbench.paths import cache_dir
from vtbench.tasks.base import Task

LOWEST = 1000
"""Seeds below are for suites and for trying out."""
GUESSABLE = 2**32
_FIRST, _SPREAD = 1_000, 100_000

_Scenes = dict[str, tuple[str, dict[str, Any]]]
_PRESSES: _Scenes = {
    "paper": ("fvsight-press", {}),
    **{name: (f"fvsight-press/{name}", {}) for name in ("default", "hard", "no-variation")},
}
_POSE: _Scenes = {
    f"jitter-{mm}mm": ("fvsight-press/default", {"pose.jitter_mm": float(mm), "pose.jitter_deg": 22.5 * mm})
    for mm in (0, 1, 2, 4, 8)
}
SCENES: Mapping[str, Mapping[str, tuple[str, dict[str, Any]]]] = {
    "objects/deep/v1": _PRESSES,
    "objects/interference/v1": _PRESSES,
    "objects/pose/v1": _POSE,
    "slip/fvsight/v1": {"paper": ("fvsight-slip", {})},
    "slip/hard/v1": {"hard": ("fvsight-slip/hard", {})},
}


def parse_seed(text: str) -> int:
    """`new` draws a seed; a number is one.

    Raises:
        ValueError: neither, or a number that suites use.
    """
    if text == "new":
        return secrets.randbelow(2**62) + GUESSABLE
    try:
        seed = int(text)
    except ValueError:
        seed = -1
    if not LOWEST <= seed < 2**63:
        raise ValueError(f"--hidden-seed: expected 'new' or a whole number of at least {LOWEST}, got {text[:40]!r}")
    return seed


def commitment(seed: int, scene_id: str) -> str:
    """SHA-256 that is published in the place of the seed."""
    return hashlib.sha256(f"vtbench hidden test set\n{scene_id}\n{seed}\n".encode()).hexdigest()


@dataclass(frozen=True)
class HiddenSet:
    """A hidden test set on disk, and what may be told of it."""

    path: Path
    commitment: str

    @property
    def name(self) -> str:
        """Name for people."""
        return f"hidden-{self.commitment[:12]}"


def make(task: Task, variant: str, seed: int, samples: int | None, jobs: int) -> HiddenSet:
    """Simulate the hidden set of a task's variant, or find it in the user's private cache.

    Raises:
        ValueError: a task on real recordings, or a variant without a scene.
    """
    from vtbench.config import load_scene
    from vtbench.data.slide_writer import write_slides
    from vtbench.data.writer import write_dataset

    scenes = SCENES.get(task.id, {})
    if variant not in scenes:
        known = ", ".join(f"{name} {', '.join(each)}" for name, each in SCENES.items())
        raise ValueError(f"{task.id}, variant {variant}: no scene to draw a hidden set from; there are: {known}")
    scene = load_scene(*scenes[variant])
    secret = commitment(seed, scene.id)
    folder = cache_dir() / "hidden"
    folder.mkdir(parents=True, exist_ok=True)
    os.chmod(folder, 0o700)
    path = folder / f"{secret[:32]}-{samples or 'all'}"
    shift = scene.n_samples * (_FIRST + int(np.random.default_rng([seed, 1]).integers(_SPREAD)))
    if scene.kind == "slide":
        write_slides(path, scene, samples=samples, seed=seed, jobs=jobs, simulate=ShiftedSlides(shift))
    else:
        write_dataset(path, scene, samples=samples, seed=seed, jobs=jobs, simulate=ShiftedPresses(shift))
    return HiddenSet(path, secret)


@dataclass(frozen=True)
class ShiftedPresses:
    """Presses further on in the protocol, on sensor units of their own; picklable."""

    shift: int

    def __call__(self, scene: Any, index: int, seed: int, truth: tuple[str, ...] = ()) -> Any:
        """Press `index` of the hidden set."""
        from sensors import press

        return press.simulate(scene, index + self.shift, seed, truth)


@dataclass(frozen=True)
class ShiftedSlides:
    """As `ShiftedPresses`, of slides."""

    shift: int

    def __call__(self, scene: Any, index: int, seed: int, frames: bool = False) -> Any:
        """Trial `index` of the hidden set."""
        from sensors.slide import simulate_slide

        return simulate_slide(scene, index + self.shift, seed, frames=frames)
