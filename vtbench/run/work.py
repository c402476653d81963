"""Cells + samples -> what a worker needs, or why a cell is not possible on these samples."""

from __future__ import annotations

from collections.abc import Sequence

from vtbench.run.cells import Cell
from vtbench.run.detection.detect import DetectionWork
from vtbench.run.evaluate import Work
from vtbench.run.methods import Method
from vtbench.tasks.base import NotPossibleError, Split, TaskData
from vtbench.tasks.slides import SlideData, SlipTask


def works_of(cells: Sequence[Cell], data: TaskData) -> tuple[list[Work | DetectionWork], dict[str, str]]:
    """Work of each cell that the data allow, and by key the reason for each that they do not allow."""
    works: list[Work | DetectionWork] = []
    impossible: dict[str, str] = {}
    splits: dict[str, Split] = {}
    for cell in cells:
        try:
            name = cell.identity.split
            if name not in splits:
                splits[name] = cell.task.variants[cell.identity.variant].splits[name](data, cell.identity.seed)
            blocks = {block.name: data.block(block.name) for block in cell.feed.blocks}
        except NotPossibleError as error:
            impossible[cell.key] = str(error)
            continue
        samples = "|".join((*cell.group, cell.identity.dataset_hash, cell.backbone))
        if isinstance(data, SlideData) and isinstance(cell.task, SlipTask):
            detector, feed = cell.method.id, cell.identity.modality
            works.append(
                DetectionWork(cell.key, detector, feed, splits[name], samples, data, cell.task, cell.timeout_s)
            )
            continue
        assert isinstance(cell.method, Method)
        works.append(
            Work(
                key=cell.key,
                method=cell.method,
                feed=cell.feed,
                split=splits[name],
                samples=samples,
                blocks=blocks,
                labels=data.labels,
                ids=data.ids,
                n_classes=len(data.classes),
                seed=cell.identity.seed,
                timeout_s=cell.timeout_s,
            )
        )
    return works, impossible
