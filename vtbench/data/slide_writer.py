"""Slip scene -> dataset on disk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vtbench.data.files import make_folder
from vtbench.data.format import FRAME_COLUMNS, SLIDE_COLUMNS
from vtbench.data.meta import Plan
from vtbench.data.shards import naming_sample, one_thread, write_shards
from vtbench.data.slide_rows import slide_row
from vtbench.data.table import Row
from vtbench.data.writer import check_counts, generator, processes

if TYPE_CHECKING:
    from sensors.slide import SlideRecording, SlipScene
    from vtbench.scheduling import Cluster

TRIALS_PER_SHARD = 12

Simulate = Callable[["SlipScene", int, int, bool], "SlideRecording"]


def write_slides(
    out: Path | str,
    scene: SlipScene,
    *,
    samples: int | None = None,
    seed: int = 0,
    jobs: int = 1,
    cluster: Cluster | None = None,
    frames: bool = False,
    progress: bool = True,
    resume: bool = True,
    samples_per_shard: int = TRIALS_PER_SHARD,
    simulate: Simulate | None = None,
) -> Path:
    """Simulate `samples` trials of `scene` into folder `out` and return it; guarantees and errors of `write_dataset`.

    Args:
        out: folder to write, created when missing.
        scene: what slides over which sensor.
        samples: number of trials, all of the scene's protocol by default.
        seed: run seed, >= 0; trial i draws from (seed, i).
        jobs: processes; -1 takes one for each core.
        cluster: workers elsewhere instead (`vtbench.scheduling.connect`).
        frames: store the camera's frames too.
        progress: show a bar on standard error when it is a terminal.
        resume: keep whole shards of an earlier call; False starts over.
        samples_per_shard: trials of one Parquet file.
        simulate: makes one trial, `sensors.slide.simulate_slide` by default; picklable for jobs > 1.
    """
    out = Path(out)
    samples = scene.n_samples if samples is None else samples
    check_counts(samples, seed, samples_per_shard)
    jobs = processes(jobs)
    make_folder(out)
    make = simulate or _simulate
    with one_thread(), naming_sample(scene.id, 0):
        first = make(scene, 0, seed, frames)
    size = first.frames.shape[1:3] if first.frames is not None else (0, 0)
    plan = Plan(
        kind="simulated",
        recordings="slides",
        name=scene.id,
        generator=generator(),
        scene=scene.model_dump(mode="json"),
        sensor={"name": "fvsight", "parameters": scene.effective_sensor().model_dump(mode="json")},
        seed=seed,
        samples=samples,
        samples_per_shard=samples_per_shard,
        classes=scene.object_names,
        n_taxels=int(np.shape(first.force_series)[-1]),
        rate_hz=float(first.rate_hz),
        image_size=(int(size[0]), int(size[1])),
        columns=(*SLIDE_COLUMNS, *(FRAME_COLUMNS if frames else ())),
    )
    make_row = _SlideRow(make, scene, plan, seed, frames)
    return write_shards(out, plan, make_row, jobs=jobs, cluster=cluster, progress=progress, resume=resume)


def _simulate(scene: SlipScene, index: int, seed: int, frames: bool) -> SlideRecording:
    from sensors.slide import simulate_slide

    return simulate_slide(scene, index, seed, frames=frames)


@dataclass(frozen=True)
class _SlideRow:
    """Row of one trial; a class, so that it can be sent to worker processes."""

    simulate: Simulate
    scene: Any
    plan: Plan
    seed: int
    frames: bool

    def __call__(self, index: int) -> Row:
        return slide_row(self.simulate(self.scene, index, self.seed, self.frames), self.plan)
