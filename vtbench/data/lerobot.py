"""Dataset -> LeRobot dataset v3.0, in its documented layout.

    meta/info.json                                   features, counts, path templates
    meta/stats.json                                  statistics of each feature
    meta/tasks.parquet                               task in words -> task_index
    meta/episodes/chunk-000/file-000.parquet         one row an episode: where its frames are, its statistics
    data/chunk-000/file-000.parquet                  one row a frame, images embedded as PNG

A press is an episode of two frames, before contact and at the hold (one nominal second apart), or of the hold alone
where the forces before contact are not known; a slide is an episode at the rate of its camera. There is no action:
nothing moves the sensor in these recordings.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from vtbench.data.files import make_folder
from vtbench.data.format import IMAGE, fixed_list, hugging_face_schema
from vtbench.data.lerobot_episodes import (
    FORCE_KEY,
    IMAGE_KEY,
    STATE_KEY,
    Episode,
    episodes,
    frames_per_second,
    tasks,
)
from vtbench.data.lerobot_stats import Tally
from vtbench.data.png import decode_png
from vtbench.data.reader import Dataset

VERSION = "v3.0"
FILE_MB = 100
FILES_PER_CHUNK = 1000
_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
_COUNTERS = {
    "timestamp": "float32",
    **dict.fromkeys(("frame_index", "episode_index", "index", "task_index"), "int64"),
}


def write_lerobot(dataset: Dataset, out: Path | str, *, file_mb: float = FILE_MB, progress: bool = True) -> Path:
    """Write `dataset` as a LeRobot dataset into folder `out` and return it; `out` is whole or absent.

    Args:
        dataset: presses or slides.
        out: folder to make; it must not exist, or be empty.
        file_mb: frames go to a new file when one has reached this size.
        progress: show a bar on standard error when it is a terminal.

    Raises:
        ValueError: `out` holds something, or recordings that LeRobot has no place for.
        OSError: the folder cannot be written.
    """
    from vtbench.run.progress import bar

    out = Path(out)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise ValueError(f"{out}: expected a new or empty folder, found something there; choose another")
    make_folder(out.parent)
    temporary = out.with_name(f".{out.name}.{os.getpid()}.tmp")
    try:
        with bar(dataset.n, "episodes", progress) as advance:
            _Writer(dataset, temporary, file_mb).run(advance)
        os.replace(temporary, out)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return out


def features(dataset: Dataset) -> dict[str, dict[str, Any]]:
    """The features of `info.json`: dtype, shape and names of every column of a frame."""
    height, width = dataset.meta.image_size
    described: dict[str, dict[str, Any]] = {}
    if height:
        described[IMAGE_KEY] = _feature("image", [height, width, 3], ["height", "width", "channels"])
    names = [f"taxel_{number}_n" for number in range(1, dataset.meta.n_taxels + 1)]
    described[FORCE_KEY] = _feature("float32", [len(names)], names)
    if dataset.meta.recordings == "slides":
        described[STATE_KEY] = _feature("int64", [1], None)
    return described | {name: _feature(dtype, [1], None) for name, dtype in _COUNTERS.items()}


def _feature(dtype: str, shape: list[int], names: list[str] | None) -> dict[str, Any]:
    return {"dtype": dtype, "shape": shape, "names": names}


def _arrow(feature: Mapping[str, Any]) -> pa.DataType:
    """How a feature lies in the frames' Parquet files."""
    if feature["dtype"] == "image":
        return IMAGE
    value = pa.float32() if feature["dtype"] == "float32" else pa.int64()
    return value if feature["shape"] == [1] else fixed_list(value, feature["shape"][0])


class _Writer:
    """Appends episodes; holds one of them and the sums in memory."""

    def __init__(self, dataset: Dataset, root: Path, file_mb: float) -> None:
        self.dataset, self.root = dataset, root
        self.limit = file_mb * 2**20
        self.fps = frames_per_second(dataset)
        self.features = features(dataset)
        self.schema = hugging_face_schema([pa.field(name, _arrow(one)) for name, one in self.features.items()])
        self.tasks = {task: index for index, task in enumerate(tasks(dataset))}
        self.tallies: dict[str, Tally] = {}
        self.rows: list[dict[str, Any]] = []
        self.frames = 0

    def run(self, advance: Callable[[int], object]) -> None:
        source = episodes(self.dataset)
        left = next(source, None)
        number = 0
        while left is not None:
            place = {"chunk_index": number // FILES_PER_CHUNK, "file_index": number % FILES_PER_CHUNK}
            path = self.root / "data" / f"{_FILE.format(**place)}.parquet"
            path.parent.mkdir(parents=True, exist_ok=True)
            with pq.ParquetWriter(path, self.schema, compression="zstd", write_statistics=False) as file:
                size = 0.0
                while left is not None and size < self.limit:
                    table = self._table(left)
                    file.write_table(table, row_group_size=len(left))
                    self._note(left, table, place)
                    size += table.nbytes
                    advance(1)
                    left = next(source, None)
            number += 1
        self._write_meta()

    def _table(self, episode: Episode) -> pa.Table:
        n = len(episode)
        if n == 0:
            raise ValueError(f"{self.dataset.path}: {episode.name} has no frame: LeRobot has no place for it")
        step = np.arange(n)
        columns: dict[str, Any] = {
            FORCE_KEY: list(episode.force),
            "timestamp": (step / self.fps).astype(np.float32),
            "frame_index": step,
            "episode_index": np.full(n, len(self.rows)),
            "index": self.frames + step,
            "task_index": np.full(n, self.tasks[episode.task]),
        }
        if episode.images is not None:
            names = [f"{episode.name.replace('/', '-')}-{number}.png" for number in range(n)]
            columns[IMAGE_KEY] = [
                {"bytes": data, "path": name} for data, name in zip(episode.images, names, strict=True)
            ]
        if episode.state is not None:
            columns[STATE_KEY] = episode.state
        return pa.table([pa.array(columns[name], self.schema.field(name).type) for name in self.features], self.schema)

    def _note(self, episode: Episode, table: pa.Table, place: Mapping[str, int]) -> None:
        """Keep the episode's row and add its sums to those of the whole."""
        stats: dict[str, Any] = {}
        for name in self.features:
            if name == IMAGE_KEY:
                tally = Tally.of_images(np.stack([decode_png(data) for data in episode.images or ()]))
            elif name == FORCE_KEY:
                tally = Tally.of(episode.force)
            else:
                tally = Tally.of(table[name].to_numpy())
            self.tallies[name] = self.tallies[name] + tally if name in self.tallies else tally
            stats |= {f"stats/{name}/{key}": value for key, value in tally.stats().items()}
        self.rows.append(
            {
                "episode_index": len(self.rows),
                "tasks": [episode.task],
                "length": len(episode),
                **{f"data/{key}": value for key, value in place.items()},
                "dataset_from_index": self.frames,
                "dataset_to_index": self.frames + len(episode),
                "meta/episodes/chunk_index": 0,
                "meta/episodes/file_index": 0,
                "recording": episode.name,
                **episode.notes,
                **stats,
            }
        )
        self.frames += len(episode)

    def _write_meta(self) -> None:
        meta = self.root / "meta"
        path = meta / "episodes" / f"{_FILE.format(chunk_index=0, file_index=0)}.parquet"
        path.parent.mkdir(parents=True)
        pq.write_table(pa.Table.from_pylist(self.rows), path, compression="zstd")
        index = pd.Index(list(self.tasks), name="task")
        pd.DataFrame({"task_index": list(self.tasks.values())}, index=index).to_parquet(meta / "tasks.parquet")
        _write_json(meta / "stats.json", {name: tally.stats() for name, tally in self.tallies.items()})
        info = {
            "codebase_version": VERSION,
            "robot_type": "fixed_tactile_sensor",
            "total_episodes": len(self.rows),
            "total_frames": self.frames,
            "total_tasks": len(self.tasks),
            "chunks_size": FILES_PER_CHUNK,
            "data_files_size_in_mb": FILE_MB,
            "video_files_size_in_mb": 200,
            "fps": self.fps,
            "splits": {"train": f"0:{len(self.rows)}"},
            "data_path": f"data/{_FILE}.parquet",
            "video_path": None,
            "features": self.features,
        }
        _write_json(meta / "info.json", info)


def _write_json(path: Path, value: object) -> None:
    path.write_text(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")
