"""Where the samples of each task and variant come from; simulated datasets are written here when they are not there."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from vtbench.run.cells import Source
from vtbench.run.suite import JOIN, DatasetSpec, Suite, dataset_ids
from vtbench.tasks import TASKS
from vtbench.tasks.base import FeatureCache, TaskData
from vtbench.tasks.slides import SlipTask, load_slides

if TYPE_CHECKING:
    from sensors.scene import PressScene
    from sensors.slide import SlipScene
    from vtbench.data.meta import DatasetMeta
    from vtbench.scheduling import Cluster


def dataset_path(out: Path, spec: DatasetSpec) -> Path:
    """Folder of a suite's dataset: below the run's, or the user's own."""
    return Path(spec.path).expanduser() if spec.path is not None else out / "datasets" / spec.id


def prepare_datasets(suite: Suite, out: Path, jobs: int, progress: bool, cluster: Cluster | None = None) -> None:
    """Simulate what is missing of the datasets that the suite's entries use; finished ones are not touched.

    Raises:
        ValueError: a scene that does not load, or a dataset of another plan in the folder.
    """
    from vtbench.data.meta import read_meta

    used = {
        dataset
        for entry in suite.entries
        if TASKS.get(entry.task).reads_dataset
        for variant, joined in entry.variants.items()
        for dataset in dataset_ids(joined or variant)
    }
    for spec in suite.datasets:
        path = dataset_path(out, spec)
        if spec.id not in used:
            continue
        if spec.scene is None:
            read_meta(path)
            continue
        from vtbench.config import load_scene
        from vtbench.data.opening import write_scene

        scene = load_scene(spec.scene, spec.set, f"dataset {spec.id}: set")
        if (path / "dataset.json").is_file():
            _check_same(path, read_meta(path), spec, scene)
            continue
        write_scene(
            path,
            scene,
            samples=spec.samples,
            seed=spec.seed,
            jobs=jobs,
            cluster=cluster,
            truth=spec.truth,
            frames=spec.frames,
            progress=progress,
        )


def find_sources(suite: Suite, out: Path) -> dict[tuple[str, str, str | None], Source]:
    """Source of every (task, variant, dataset) of the entries; one that is missing says why. Reads no sample."""
    from vtbench.data.meta import read_meta

    specs = {spec.id: spec for spec in suite.datasets}
    found = {}
    for entry in suite.entries:
        task = TASKS.get(entry.task)
        for variant, dataset in entry.variants.items():
            if task.reads_dataset:
                names = dataset_ids(dataset or variant)
                metas = [read_meta(dataset_path(out, specs[name])) for name in names]
                kind = task.kind if all(meta.kind == "simulated" for meta in metas) else "real"
                source = Source(JOIN.join(names), joined_hash([meta.hash for meta in metas]), kind)
            else:
                source = _public(task.reads)
            found[task.id, variant, dataset] = source
    return found


def load_samples(
    suite: Suite, out: Path, task_id: str, dataset: str, features: FeatureCache, backbone: str | None = None
) -> TaskData:
    """Samples of a task from the dataset of that name, their frames through `backbone` or the suite's."""
    task, paths = TASKS.get(task_id), source_paths(suite, out, task_id, dataset)
    if isinstance(task, SlipTask):
        return load_slides(paths)
    return task.load(paths[0], features, backbone or suite.backbone)


def source_paths(suite: Suite, out: Path, task_id: str, dataset: str) -> tuple[Path, ...]:
    """Folders from which a task loads the dataset of that name, which may join several."""
    task = TASKS.get(task_id)
    if task.reads_dataset:
        specs: Mapping[str, DatasetSpec] = {spec.id: spec for spec in suite.datasets}
        return tuple(dataset_path(out, specs[name]) for name in dataset_ids(dataset))
    from vtbench.data import data_root

    return (data_root(task.reads),)


def _check_same(path: Path, meta: DatasetMeta, spec: DatasetSpec, scene: PressScene | SlipScene) -> None:
    """Refuse a finished dataset that is not what the suite asks for."""
    asked = {
        "scene": scene.model_dump(mode="json"),
        "samples": scene.n_samples if spec.samples is None else spec.samples,
        "seed": spec.seed,
        "truth": set(spec.truth),
        "frames": spec.frames or scene.kind != "slide",
    }
    there = {"scene": meta.scene, "samples": meta.samples, "seed": meta.seed, "truth": set(meta.truth)}
    there["frames"] = "frames" in meta.columns or scene.kind != "slide"
    if differing := [name for name in asked if asked[name] != there[name]]:
        raise ValueError(
            f"{path}: its {', '.join(differing)} {'is' if len(differing) == 1 else 'are'} not what the suite asks for; "
            "choose a new folder or delete this one"
        )


def joined_hash(hashes: list[str]) -> str:
    """Content hash of several datasets together; of one its own."""
    return hashes[0] if len(hashes) == 1 else hashlib.sha256("".join(hashes).encode()).hexdigest()


def _public(name: str) -> Source:
    """Public recordings: hashed by their manifest of checksums, so that nothing is read."""
    from vtbench.data.public import data_root, public_set

    digest = hashlib.sha256(public_set(name).manifest.read_bytes()).hexdigest()
    try:
        data_root(name)
    except ValueError as error:
        return Source(name, digest, "real", missing=str(error))
    return Source(name, digest, "real")
