"""Learnt on clean presses: what is left when the array or the camera fails?

Data: deep presses; one fault a variant, in the test part alone (`corruptions` states each), drawn for each press. A
frame is spoilt before the backbone sees it; its rest frame is as it was recorded. A force history has the fault of its
press at every step. Choices are made on clean training folds, so that no method is tuned to a fault.
`no-force` and `no-image` take a modality away: sparse coding gives it weight 0, nets are told by name, and any other
method sees the training mean in its place. `camera-black` is the camera that is gone and nobody says so.
Splits: each half of an object's presses tested by the other (every press once), and each sensor unit held out.
Target, metrics, intervals: as `objects/deep/v1`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vtbench.tasks import presses
from vtbench.tasks.base import MISSING, Block, FeatureCache, Features, Feed, StandIn, Task, TaskData, Variant
from vtbench.tasks.corruptions import FORCE_FAULTS, FRAME_FAULTS, VERSION, faulty_forces, faulty_frames
from vtbench.tasks.presses import (
    CHANGE,
    FORCE,
    PIXELS_CHANGE,
    PROBES,
    SERIES,
    STEPS,
    backbone_identity,
    in_steps,
    load_presses,
)
from vtbench.tasks.splits import held_out
from vtbench.tasks.study_splits import halves

SPLITS = {"random": halves, "held-out-unit": held_out("unit")}


def _load(path: Path, features: FeatureCache, backbone: str) -> TaskData:
    from vtbench.data import Dataset

    data = load_presses(path, features, backbone, press="deep")
    made = {f"{FORCE.name}~{fault}": partial(_forces, path, fault) for fault in FORCE_FAULTS}
    if SERIES.name in data.sources:
        made |= {f"{SERIES.name}~{fault}": partial(_histories, path, fault) for fault in FORCE_FAULTS}
    if CHANGE.name in data.sources:
        dataset = Dataset.open(path, verify=False)
        for block, network in ((CHANGE.name, backbone), (PIXELS_CHANGE.name, "pixels")):
            for fault in FRAME_FAULTS:
                identity = {
                    "dataset": dataset.hash,
                    "frames": CHANGE.name,
                    "fault": f"{fault}, version {VERSION}",
                    **backbone_identity(network),
                }
                compute = partial(_frame_features, path, fault, network)
                made[f"{block}~{fault}"] = partial(features.cached, identity, dataset.n, compute)
    return replace(data, sources={**data.sources, **made})


def _forces(path: Path, fault: str) -> Features:
    from vtbench.data import Dataset

    dataset = Dataset.open(path, verify=False)
    return faulty_forces(fault, dataset.force(), dataset.columns(["id"])["id"].tolist())


def _histories(path: Path, fault: str) -> Features:
    """The block of force histories, (rows, steps * taxels), with the fault of `_forces`."""
    from vtbench.data import Dataset

    dataset = Dataset.open(path, verify=False)
    series = in_steps(dataset.force_series(), STEPS)
    spoilt = faulty_forces(fault, series.reshape(len(series), STEPS, -1), dataset.columns(["id"])["id"].tolist())
    return spoilt.reshape(series.shape)


def _frame_features(path: Path, fault: str, backbone: str, rows: NDArray[np.int64]) -> Features:
    """Backbone features (rows, columns) of what changed against the rest frame, the frame spoilt before."""
    from vtbench.data import Dataset

    dataset = Dataset.open(path, verify=False)
    rest = dataset.images(rows, column="image_rest")
    ids = dataset.columns(["id"])["id"].to_numpy()[rows].tolist()
    spoilt = faulty_frames(fault, dataset.images(rows), rest, ids)
    return presses._backbone(backbone).extract(presses.change(spoilt, rest))


def _tested(about: str, blocks: tuple[Block, ...], stand_in: str) -> Variant:
    """Every one of `blocks` is tested as `block~stand_in`, or not at all."""
    missing = stand_in == MISSING
    return Variant(
        about,
        SPLITS,
        stand_ins={block.name: StandIn(test=MISSING if missing else f"{block.name}~{stand_in}") for block in blocks},
    )


OF_ARRAY, OF_CAMERA = (FORCE, SERIES), (CHANGE, PIXELS_CHANGE)

TASK = Task(
    id="robustness/v1",
    about="name the pressed object with faults of array and camera that training never saw",
    reads="presses",
    load=_load,
    variants={
        "clean": Variant("no fault", SPLITS),
        **{name: _tested(fault.about, OF_ARRAY, name) for name, fault in FORCE_FAULTS.items()},
        **{name: _tested(fault.about, OF_CAMERA, name) for name, fault in FRAME_FAULTS.items()},
        "no-force": _tested("the array is gone", OF_ARRAY, MISSING),
        "no-image": _tested("the camera is gone", OF_CAMERA, MISSING),
    },
    modalities={
        "force": Feed((FORCE,)),
        "image-change": Feed((CHANGE,)),
        "fused-change": Feed((CHANGE, FORCE), weights="chosen"),
        "fused-change-equal": Feed((CHANGE, FORCE)),
        "pixels-change": Feed((PIXELS_CHANGE,), by_name=True),
        "force-series": Feed((SERIES,), by_name=True),
        "fused-pixels-change-equal": Feed((PIXELS_CHANGE, SERIES), by_name=True),
    },
    probes=PROBES,
)
