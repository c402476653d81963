"""How much detail of touch helps, alone and beside the camera?

Data: deep presses. Feeds, from coarse to fine: `contact` (one bit: is more than 0.2 N felt), `location` (centroid of
the taxel forces), `touched` (one bit a taxel), `force` (16 taxels) and `pressure` (the true pressure map, averaged to
32 x 32; what no sensor gives). `change` is the camera alone, and `change+...` the camera beside each.
A deep press always touches, so `contact` has nothing to tell; it stands for a switch in place of an array.
Splits: each half of an object's presses tested by the other (every press once), and each sensor unit held out.
Target, metrics, intervals: as `objects/deep/v1`.

The order that the penalty-contact lecture reports: full contact, then contact location, then binary contact, which
equals none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from vtbench.tasks.base import Block, FeatureCache, Features, Feed, Task, TaskData, Variant
from vtbench.tasks.presses import CHANGE, FORCE, PROBES, TRUTH_SIDE, averaged, load_presses
from vtbench.tasks.splits import held_out
from vtbench.tasks.study_splits import halves

FELT_N = 0.2
"""Resolution of a taxel of the FVSight array, newtons: what is below is not felt."""

CONTACT = Block("contact")
LOCATION = Block("load-centroid")
TOUCHED = Block("touched")
PRESSURE = Block("pressure", components=(16, 32, 64))
TOUCH = {
    "contact": CONTACT,
    "location": LOCATION,
    "touched": TOUCHED,
    "force": FORCE,
    "pressure": PRESSURE,
}


def _load(path: Path, features: FeatureCache, backbone: str) -> TaskData:
    from vtbench.data import Dataset

    data = load_presses(path, features, backbone, press="deep")
    dataset = Dataset.open(path, verify=False)
    made: dict[str, Callable[[], Features]] = {
        CONTACT.name: lambda: felt(dataset.force().max(1, keepdims=True)),
        TOUCHED.name: lambda: felt(dataset.force()),
    }
    if "pressure" in dataset.meta.truth:
        made[PRESSURE.name] = lambda: averaged(dataset.truth("pressure"), TRUTH_SIDE)
    return replace(data, sources={**data.sources, **made})


def felt(force: Features) -> Features:
    """1 where a force in newtons is above what a taxel resolves, else 0."""
    return (force > FELT_N).astype(np.float32)


def _feed(block: Block, beside: bool) -> Feed:
    truth = "pressure" if block is PRESSURE else None
    if beside:
        return Feed((CHANGE, block), weights="chosen", needs_truth=truth)
    return Feed((block,), needs_truth=truth)


_SPLITS = {"random": halves, "held-out-unit": held_out("unit")}

TASK = Task(
    id="granularity/v1",
    about="name the pressed object from finer and finer touch, alone and beside the camera",
    reads="presses",
    load=_load,
    variants={
        "spread": Variant("places that differ from press to press", _SPLITS),
        "own": Variant("your own recordings", _SPLITS),
    },
    modalities={
        **{name: _feed(block, False) for name, block in TOUCH.items()},
        "change": Feed((CHANGE,)),
        **{f"change+{name}": _feed(block, True) for name, block in TOUCH.items()},
    },
    probes=PROBES,
)
