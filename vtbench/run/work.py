"""Cells + samples -> what a worker needs, or why a cell is not possible on these samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vtbench.run.cells import Cell
from vtbench.run.detection.detect import DetectionWork
from vtbench.run.evaluate import Work
from vtbench.run.methods import Method
from vtbench.tasks.base import MISSING, Features, NotPossibleError, Split, StandIn, TaskData, Variant
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
            blocks = {
                block.name: read_block(data, block.name, cell.task.variants[cell.identity.variant])
                for block in cell.feed.blocks
            }
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
        stand_ins = cell.task.variants[cell.identity.variant].stand_ins
        trained = sorted((name, way.train) for name, way in stand_ins.items() if way.train)
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
                trained="|".join((cell.identity.task, cell.identity.dataset_hash, cell.backbone, str(trained))),
                tested_from=len(data) if stand_ins else 0,
                missing=tuple(
                    block.name
                    for block in cell.feed.blocks
                    if block.name in stand_ins and stand_ins[block.name].test == MISSING
                ),
            )
        )
    return works, impossible


def read_block(data: TaskData, name: str, variant: Variant) -> Features:
    """Features (n, columns) of a block; (2 n, columns) where the variant reads stand-ins: as trained, then as tested.

    Raises:
        NotPossibleError: the data do not hold what is read.
    """
    if not variant.stand_ins:
        return data.block(name)
    way = variant.stand_ins.get(name, StandIn())
    trained = data.block(way.train or name)
    tested = trained if way.test == MISSING else data.block(way.test or name)
    return np.concatenate([trained, tested])
