"""A dataset of either kind, by what its `dataset.json` says it holds; a scene of either kind, written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from vtbench.data.meta import read_meta
from vtbench.data.reader import Dataset, Verify

if TYPE_CHECKING:
    from sensors.scene import PressScene
    from sensors.slide import SlipScene
    from vtbench.scheduling import Cluster


def open_dataset(path: Path | str, verify: Verify = "size") -> Dataset:
    """Open a dataset of presses (`Dataset`) or of slides (`SlideDataset`); errors as `Dataset.open`."""
    if read_meta(Path(path)).recordings == "slides":
        from vtbench.data.slide_reader import SlideDataset

        return SlideDataset.open(path, verify)
    return Dataset.open(path, verify)


def write_scene(
    out: Path | str,
    scene: PressScene | SlipScene,
    *,
    samples: int | None = None,
    seed: int = 0,
    jobs: int = 1,
    cluster: Cluster | None = None,
    truth: Sequence[str] = (),
    frames: bool = False,
    progress: bool = True,
    resume: bool = True,
) -> Path:
    """`write_dataset` for a scene of presses, `write_slides` for one of slides.

    Raises:
        ValueError: `truth` of slides, which always keep their state, or `frames` of presses, which always have them.
    """
    if scene.kind == "slide":
        if truth:
            raise ValueError(f"truth: {scene.id} is a slip scene, which keeps its state and onset and no such fields")
        from vtbench.data.slide_writer import write_slides

        return write_slides(
            out,
            scene,
            samples=samples,
            seed=seed,
            jobs=jobs,
            cluster=cluster,
            frames=frames,
            progress=progress,
            resume=resume,
        )
    if frames:
        raise ValueError(f"frames: {scene.id} is a press scene, each of its presses has its frame anyway")
    from vtbench.data.writer import write_dataset

    return write_dataset(
        out,
        scene,
        samples=samples,
        seed=seed,
        jobs=jobs,
        cluster=cluster,
        truth=truth,
        progress=progress,
        resume=resume,
    )
