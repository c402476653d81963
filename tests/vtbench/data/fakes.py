"""A cheap scene and its recordings, for tests of the format; importable by worker processes."""

import os
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

OBJECTS = ("ball", "coin", "key", "pen")
SIZE = 24
GRID = 8


@dataclass(frozen=True)
class FakeRecording:
    image: Any
    image_rest: Any
    force_series: Any
    rate_hz: float
    force: Any
    taxel_load: Any
    total_force_n: float
    indentation_mm: float
    hold: tuple[int, int]
    image_time_s: float
    labels: dict[str, Any]
    truth: dict[str, Any]


@dataclass(frozen=True)
class FakeScene:
    id: str = "fake-press"
    object_names: tuple[str, ...] = OBJECTS
    n_samples: int = 26
    settings: dict[str, float] = field(default_factory=lambda: {"load_n": 5.0})

    def model_dump(self, mode: str = "json") -> dict[str, Any]:
        return {"id": self.id, "objects": list(self.object_names), "settings": dict(self.settings)}


def describe(scene: FakeScene) -> dict[str, Any]:
    return {"taxels": 16, "range_n": [0.0, 50.0]}


def simulate(scene: FakeScene, index: int, seed: int, truth: tuple[str, ...] = ()) -> FakeRecording:
    rng = np.random.default_rng([seed, index])
    name = scene.object_names[index % len(scene.object_names)]
    length = 30 + index % 3
    series = rng.gamma(2.0, 0.5, (length, 16)).astype(np.float32)
    grids = {
        "displacement": rng.random((GRID, GRID)).astype(np.float32),
        "pressure": rng.random((GRID, GRID)).astype(np.float32),
        "contact": rng.random((GRID, GRID)) > 0.5,
    }
    return FakeRecording(
        image=rng.integers(0, 256, (SIZE, SIZE, 3), dtype=np.uint8),
        image_rest=rng.integers(0, 256, (SIZE, SIZE, 3), dtype=np.uint8),
        force_series=series,
        rate_hz=1000.0,
        force=series[10:20].mean(axis=0),
        taxel_load=rng.random(16).astype(np.float32),
        total_force_n=float(series[15].sum()),
        indentation_mm=1.5,
        hold=(10, 20),
        image_time_s=0.015,
        labels={
            "id": f"fake/{seed}/{index:05d}",
            "object": name,
            "label": index % len(scene.object_names),
            "press": "shallow" if index % 5 == 4 else "deep",
            "unit": index // 13,
            "session": index // 7,
            "round": index // len(scene.object_names),
            "seed": seed,
            "pose_x_mm": float(rng.normal()),
            "pose_y_mm": float(rng.normal()),
            "pose_deg": float(rng.normal()),
        },
        truth={name: grids[name] for name in truth},
    )


def simulate_slowly(scene: FakeScene, index: int, seed: int, truth: tuple[str, ...] = ()) -> FakeRecording:
    time.sleep(0.05)
    return simulate(scene, index, seed, truth)


def simulate_nan_force(scene: FakeScene, index: int, seed: int, truth: tuple[str, ...] = ()) -> FakeRecording:
    recording = simulate(scene, index, seed, truth)
    if index == 9:
        recording.force[3] = np.nan
    return recording


def simulate_and_fail(scene: FakeScene, index: int, seed: int, truth: tuple[str, ...] = ()) -> FakeRecording:
    if index == 9:
        raise ZeroDivisionError("no contact\nanywhere")
    return simulate(scene, index, seed, truth)


def simulate_and_die(scene: FakeScene, index: int, seed: int, truth: tuple[str, ...] = ()) -> FakeRecording:
    if index == 21:
        os._exit(1)
    return simulate(scene, index, seed, truth)
