"""Scene -> dataset on disk."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vtbench.data.files import make_folder
from vtbench.data.format import SAMPLES_PER_SHARD, SIMULATED_COLUMNS, TRUTH_UNITS
from vtbench.data.meta import Plan
from vtbench.data.rows import recording_row
from vtbench.data.shards import naming_sample, one_thread, write_shards
from vtbench.data.table import Row

if TYPE_CHECKING:
    from sensors.recording import Recording
    from sensors.scene import PressScene
    from vtbench.scheduling import Cluster

Simulate = Callable[["PressScene", int, int, tuple[str, ...]], "Recording"]
Describe = Callable[["PressScene"], dict[str, Any]]


def write_dataset(
    out: Path | str,
    scene: PressScene,
    *,
    samples: int | None = None,
    seed: int = 0,
    jobs: int = 1,
    cluster: Cluster | None = None,
    truth: Sequence[str] = (),
    progress: bool = True,
    resume: bool = True,
    samples_per_shard: int = SAMPLES_PER_SHARD,
    simulate: Simulate | None = None,
    describe: Describe | None = None,
) -> Path:
    """Simulate `samples` recordings of `scene` into folder `out` and return it.

    A call that was killed goes on from its last whole shard when it is made again; a finished one does
    nothing. The bytes depend on scene, seed, `truth` and versions, never on `jobs`.

    Args:
        out: folder to write, created when missing.
        scene: what is pressed on which sensor.
        samples: number of presses, all of the scene's protocol by default.
        seed: run seed, >= 0; sample i draws from (seed, i).
        jobs: processes; -1 takes one for each core.
        cluster: workers elsewhere instead (`vtbench.scheduling.connect`).
        truth: ground-truth fields to store, of `displacement` [m], `pressure` [Pa], `contact`.
        progress: show a bar on standard error when it is a terminal.
        resume: keep whole shards of an earlier call; False starts over.
        samples_per_shard: rows of one Parquet file.
        simulate: makes the recording of one sample, `sensors.simulate` by default; picklable for jobs > 1.
        describe: gives the sensor's parameters for `dataset.json`; `sensors.describe` by default.

    Raises:
        ValueError: an argument out of range, a folder with something else in it, a sample that fails.
        OSError: the folder cannot be written, the disk is full, or a worker process died.
    """
    out = Path(out)
    samples = scene.n_samples if samples is None else samples
    check_counts(samples, seed, samples_per_shard)
    for field in truth:
        if field not in TRUTH_UNITS:
            raise ValueError(f"truth: unknown field {field!r}; expected some of {', '.join(TRUTH_UNITS)}")
    jobs = processes(jobs)
    make_folder(out)
    fields = tuple(name for name in TRUTH_UNITS if name in truth)
    if simulate is None:
        from sensors import press

        simulate = press.simulate
    if describe is None:
        from sensors.sensor_card import describe as describe_sensor

        describe = describe_sensor
    with one_thread(), naming_sample(scene.id, 0):
        first = simulate(scene, 0, seed, fields)
    plan = Plan(
        kind="simulated",
        name=scene.id,
        generator=generator(),
        scene=scene.model_dump(mode="json"),
        sensor=describe(scene),
        seed=seed,
        samples=samples,
        samples_per_shard=samples_per_shard,
        classes=scene.object_names,
        n_taxels=int(np.shape(first.force)[-1]),
        rate_hz=float(first.rate_hz),
        image_size=(int(first.image.shape[0]), int(first.image.shape[1])),
        truth={field: _grid(first, field) for field in fields},
        columns=(*SIMULATED_COLUMNS, *(f"truth_{field}" for field in fields)),
    )
    make_row = _SimulatedRow(simulate, scene, plan, seed, fields)
    return write_shards(out, plan, make_row, jobs=jobs, cluster=cluster, progress=progress, resume=resume)


def generator() -> dict[str, str]:
    """Versions of what decides the bytes of a dataset."""
    libraries = {"opencv": "opencv-contrib-python-headless"}
    names = ("vtbench", "numpy", "scipy", "opencv", "pyarrow")
    return {name: _version(libraries.get(name, name)) for name in names}


@dataclass(frozen=True)
class _SimulatedRow:
    """Row of one sample; a class, so that it can be sent to worker processes."""

    simulate: Simulate
    scene: PressScene
    plan: Plan
    seed: int
    truth: tuple[str, ...]

    def __call__(self, index: int) -> Row:
        return recording_row(self.simulate(self.scene, index, self.seed, self.truth), self.plan)


def _grid(recording: Recording, field: str) -> tuple[int, int]:
    rows, columns = recording.truth[field].shape
    return rows, columns


def check_counts(samples: int, seed: int, samples_per_shard: int) -> None:
    """Raise ValueError for a number that is out of range."""
    if samples < 1:
        raise ValueError(f"samples: expected at least 1, got {samples}")
    if seed < 0:
        raise ValueError(f"seed: expected 0 or more, got {seed}")
    if samples_per_shard < 1:
        raise ValueError(f"samples_per_shard: expected at least 1, got {samples_per_shard}")


def processes(jobs: int) -> int:
    """Number of processes that `jobs` asks for; ValueError below 1 except for -1, every core."""
    if jobs == -1:
        from joblib import cpu_count

        return int(cpu_count())
    if jobs < 1:
        raise ValueError(f"jobs: expected at least 1, or -1 for every core, got {jobs}")
    return jobs


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        if package.startswith("opencv"):
            import cv2

            return str(cv2.__version__)
        return "unknown"
