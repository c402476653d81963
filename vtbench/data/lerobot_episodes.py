"""Recordings as LeRobot sees them: episodes of frames with an image, the taxels' forces and a task in words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from vtbench.data.reader import Dataset

IMAGE_KEY = "observation.images.camera"
FORCE_KEY = "observation.force"
STATE_KEY = "observation.slip_state"
PRESS_FPS = 1


@dataclass(frozen=True)
class Episode:
    """One recording.

    Attributes:
        name: its id in the dataset.
        task: what is done, in words.
        notes: further columns of the episode's row.
        force: (F, taxels) float32 newtons, one row a frame.
        images: PNG bytes of each frame; None where the recordings have no frames.
        state: (F,) int64, 0 stick, 1 partial slip, 2 gross slip; None of presses.
    """

    name: str
    task: str
    notes: dict[str, Any]
    force: NDArray[np.float32]
    images: tuple[bytes, ...] | None = None
    state: NDArray[np.int64] | None = None

    def __len__(self) -> int:
        return len(self.force)


def frames_per_second(dataset: Dataset) -> int:
    """Rate of the episodes' frames: of slides the camera's, or the forces' without one; of presses nominal.

    Raises:
        ValueError: forces whose rate is no whole number of hertz, which LeRobot asks for.
    """
    if dataset.meta.recordings == "presses":
        return PRESS_FPS
    if "frames" in dataset.meta.columns:
        steps = np.concatenate([np.diff(times) for times in _frame_times(dataset)])
        return max(1, round(1.0 / float(np.median(steps)))) if steps.size else PRESS_FPS
    rate = dataset.meta.rate_hz or 0.0
    if rate < 1 or rate != round(rate):
        raise ValueError(f"{dataset.path}: LeRobot asks for a whole number of frames a second, the forces have {rate}")
    return round(rate)


def tasks(dataset: Dataset) -> list[str]:
    """The task of each class, in the order of the classes."""
    return [_task(dataset, name) for name in dataset.classes]


def episodes(dataset: Dataset) -> Iterator[Episode]:
    """The recordings in order, one shard in memory at a time."""
    make = _slide if dataset.meta.recordings == "slides" else _press
    for shard in dataset.meta.shards:
        table = pq.read_table(dataset.path / shard.name, partitioning=None)
        for row in range(table.num_rows):
            yield make(dataset, {name: table[name][row] for name in table.column_names})


def _press(dataset: Dataset, row: dict[str, pa.Scalar]) -> Episode:
    """The hold, and before it the frame without contact where its forces are known."""
    notes = {name: row[name].as_py() for name in ("object", "press", "unit", "session")}
    forces = [np.array(row["force"].as_py(), np.float32)]
    images = [row["image"].as_py()["bytes"]]
    if "image_rest" in row and "force_series" in row:
        forces.insert(0, np.array(row["force_series"][0].as_py(), np.float32))
        images.insert(0, row["image_rest"].as_py()["bytes"])
    return Episode(row["id"].as_py(), _task(dataset, notes["object"]), notes, np.stack(forces), tuple(images))


def _slide(dataset: Dataset, row: dict[str, pa.Scalar]) -> Episode:
    """Forces and state at the moments of the frames; every sample of the forces where there are no frames."""
    notes = {name: row[name].as_py() for name in ("object", "kind", "unit", "session")}
    series = row["force_series"].values.flatten().to_numpy().reshape(-1, dataset.meta.n_taxels)
    state = row["state"].values.to_numpy().astype(np.int64)
    images = None
    if "frames" in row:
        rate = row["rate_hz"].as_py()
        times = row["frame_time_s"].values.to_numpy()
        at = np.clip(np.floor(times * rate + 1e-6).astype(np.int64), 0, len(series) - 1)
        series, state = series[at], state[at]
        images = tuple(frame["bytes"] for frame in row["frames"].as_py())
    return Episode(row["id"].as_py(), _task(dataset, notes["object"]), notes, series, images, state)


def _frame_times(dataset: Dataset) -> list[NDArray[np.float64]]:
    """Times of the frames of the first shard's trials; one camera took them all."""
    first = dataset.meta.shards[0].name
    cells = pq.read_table(dataset.path / first, columns=["frame_time_s"], partitioning=None)["frame_time_s"]
    return [cell.values.to_numpy() for cell in cells]


def _task(dataset: Dataset, name: str) -> str:
    return f"{'slide over' if dataset.meta.recordings == 'slides' else 'press'} {name}"
