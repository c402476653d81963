"""A cheap slip scene and its trials, for tests; importable by worker processes."""

import os
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from sensors.slide import SlideRecording

RATE_HZ = 1000.0
REST_S = 0.8
QUIET_N, SLIP_N = 0.004, 0.05


@dataclass(frozen=True)
class FakeSlipScene:
    """Every `period`-th trial has no slip but one coherent change of load; the others rest, slip, rest."""

    id: str = "fake-slip"
    object_names: tuple[str, ...] = ("ball", "cuboid", "cylinder")
    n_samples: int = 12
    period: int = 0
    samples: int = 2400
    motion: dict[str, float] = field(default_factory=lambda: {"rest_s": 1.0, "rest_jitter_s": 0.2})

    kind = "slide"

    def model_dump(self, mode: str = "json") -> dict[str, Any]:
        return {"id": self.id, "motion": dict(self.motion), "period": self.period}

    def effective_sensor(self) -> Any:
        return SimpleNamespace(model_dump=lambda mode: {})


def simulate(scene: FakeSlipScene, index: int, seed: int, frames: bool = False) -> SlideRecording:
    rng = np.random.default_rng([seed, index])
    cycle = index // len(scene.object_names)
    slips = scene.period == 0 or cycle % scene.period != scene.period - 1
    force = 0.3 + QUIET_N * rng.standard_normal((scene.samples, 16))
    state = np.zeros(scene.samples, np.uint8)
    onset = None
    if slips:
        onset = 1000 + int(rng.integers(0, 100))
        state[onset - 40 : onset] = 1
        state[onset : onset + 700] = 2
        swing = SLIP_N * np.sin(np.arange(700)[:, None] * 0.5 + np.arange(16))
        force[onset : onset + 700] += swing + SLIP_N * rng.standard_normal((700, 16))
    else:
        force[900:] *= 2.0
    return SlideRecording(
        force_series=force.astype(np.float32),
        rate_hz=RATE_HZ,
        state=state,
        onset_sample=onset,
        labels={
            "id": f"{index:06d}",
            "object": scene.object_names[index % len(scene.object_names)],
            "kind": "slide" if slips else "load_change",
            "trial": cycle,
            "unit": index % 2,
            "session": 0,
            "speed_mm_s": 10.0 if slips else 0.0,
            "rotation_deg_s": 0.0,
            "load_n": 5.0,
            "direction_deg": 0.0,
            "seed": seed,
        },
        frames=rng.integers(0, 256, (3, 8, 10, 3), dtype=np.uint8) if frames else None,
        frame_time_s=np.arange(3) / 30 if frames else np.empty(0),
    )


def simulate_and_die(scene: FakeSlipScene, index: int, seed: int, frames: bool = False) -> SlideRecording:
    if index == 9:
        os._exit(1)
    return simulate(scene, index, seed, frames)


def simulate_false_onset(scene: FakeSlipScene, index: int, seed: int, frames: bool = False) -> SlideRecording:
    recording = simulate(scene, index, seed, frames)
    return SlideRecording(
        recording.force_series, RATE_HZ, recording.state, (recording.onset_sample or 0) + 1, recording.labels
    )
