"""How much does fusion need frame and force to belong together?

Data: deep presses; the force of a frame is replaced, before learning and testing alike, so that a variant is a pair of
sensors that is badly paired for good. The object's label always belongs to the frame.

- `time-X`: force of another moment; the clocks of a press differ by up to X ms, drawn for each press. The load stands
  still for 200 ms about the frame, so that only larger errors reach approach and release.
- `place-X`: force of another press of the object, X mm away as nearly as the presses allow (in the suite `studies`,
  with four others to choose from: medians 2.3, 4.0 and 5.7 mm for 2, 4 and 6).
- `press-other`: force of any other press of the object. `class-other`: of another object, the control: no method
  can gain from it, and one that listens to it loses.
- `test-press`, `test-class`: the same two, but the training pairs are right.

Partners are of the same sensor and the same half of its presses, so that no force crosses from training to test. A
force history (`force-series`, the feed of nets) has the partner, and the error of the clocks, of its press's force: it
is late or early by that much, and held at its ends.
Splits: each half of an object's presses tested by the other (every press once), and each sensor unit held out.
Target, metrics, intervals: as `objects/deep/v1`. Lines to compare with: each modality alone on `paired`. Beside the
change of the frame the force has little to add on these presses; beside the raw frame (`fused-equal`, the paper's own
feed, on the random split, where raw frames can be used at all) it has, so that there is something to lose.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vtbench.tasks.base import FeatureCache, Features, Feed, StandIn, Task, TaskData, Variant
from vtbench.tasks.mispairing import another, clock_errors, force_at, late, nearest_distance, of_another_class
from vtbench.tasks.presses import (
    CHANGE,
    FORCE,
    FRAME,
    PIXELS_CHANGE,
    PROBES,
    SERIES,
    STEPS,
    in_steps,
    load_presses,
)
from vtbench.tasks.splits import held_out
from vtbench.tasks.study_splits import half_of, halves, pools

if TYPE_CHECKING:
    import pandas as pd

    from vtbench.data import Dataset

Rows = NDArray[np.int64]
TIMES_MS = (100, 200, 300, 400)
PLACES_MM = (2, 4, 6)
SEED = 1
SPLITS = {"random": halves, "held-out-unit": held_out("unit")}
OF_FORCE = (FORCE.name, SERIES.name)


def _load(path: Path, features: FeatureCache, backbone: str) -> TaskData:
    data = load_presses(path, features, backbone, press="deep")
    made = {f"{FORCE.name}~time-{ms}ms": partial(_other_moment, path, ms) for ms in TIMES_MS}
    partners = {f"place-{mm}mm": partial(_other_place, data, mm) for mm in PLACES_MM}
    partners |= {"press": partial(_other_press, data), "class": partial(_other_class, data)}
    forces = [FORCE.name]
    if SERIES.name in data.sources:
        forces.append(SERIES.name)
        made |= {f"{SERIES.name}~time-{ms}ms": partial(_other_time, path, ms) for ms in TIMES_MS}
    made |= {
        f"{force}~{name}": partial(_taken_from, data, force, partner)
        for force in forces
        for name, partner in partners.items()
    }
    return replace(data, sources={**data.sources, **made})


def _other_moment(path: Path, ms: int) -> Features:
    dataset, table, errors = _with_clock_errors(path, ms)
    moments = table["image_time_s"].to_numpy() + errors
    return force_at(dataset.force_series(), table["rate_hz"].to_numpy(), moments)


def _other_time(path: Path, ms: int) -> Features:
    """Histories with the clock errors of `_other_moment`."""
    dataset, table, errors = _with_clock_errors(path, ms)
    return in_steps(late(dataset.force_series(), table["rate_hz"].to_numpy(), errors), STEPS)


def _with_clock_errors(path: Path, ms: int) -> tuple[Dataset, pd.DataFrame, NDArray[np.float64]]:
    """The dataset, the times of its samples, and how far (s) the clock of each is off."""
    from vtbench.data import Dataset

    dataset = Dataset.open(path, verify=False)
    table = dataset.columns(["id", "rate_hz", "image_time_s"])
    return dataset, table, clock_errors(table["id"].tolist(), ms / 1e3)


def _other_place(data: TaskData, mm: int) -> Rows:
    places = np.stack([data.factor("pose_x_mm"), data.factor("pose_y_mm")], 1)
    return nearest_distance(_same_object(data), places, mm)


def _other_press(data: TaskData) -> Rows:
    return another(_same_object(data), SEED)


def _other_class(data: TaskData) -> Rows:
    return of_another_class(pools(half_of(data), *_unit(data)), data.labels, SEED)


def _same_object(data: TaskData) -> Rows:
    return pools(data.labels, half_of(data), *_unit(data))


def _unit(data: TaskData) -> list[Rows]:
    return [data.factors["unit"]] if "unit" in data.factors else []


def _taken_from(data: TaskData, force: str, partner: Callable[[], Rows]) -> Features:
    """Block `force` of the whole dataset, with that of the task's samples replaced by their partners'."""
    own = data.sources[force]()
    given = own.copy()
    given[data.rows] = own[data.rows[partner()]]
    return given


def _both(about: str, other: str) -> Variant:
    """Force and its history are those of `other`, in training and testing."""
    return Variant(about, SPLITS, stand_ins={name: StandIn(f"{name}~{other}", f"{name}~{other}") for name in OF_FORCE})


def _test_only(about: str, other: str) -> Variant:
    return Variant(about, SPLITS, stand_ins={name: StandIn(test=f"{name}~{other}") for name in OF_FORCE})


TASK = Task(
    id="pairing/v1",
    about="name the pressed object while frame and force belong together less and less",
    reads="presses",
    load=_load,
    variants={
        "paired": Variant("frame and force of one press, as recorded", SPLITS),
        **{f"time-{ms}ms": _both(f"clocks differ by up to {ms} ms", f"time-{ms}ms") for ms in TIMES_MS},
        **{f"place-{mm}mm": _both(f"force of a press about {mm} mm away", f"place-{mm}mm") for mm in PLACES_MM},
        "press-other": _both("force of any other press of the object", "press"),
        "class-other": _both("force of another object: the control", "class"),
        "test-press": _test_only("learnt on right pairs, tested with another press of the object", "press"),
        "test-class": _test_only("learnt on right pairs, tested with the force of another object", "class"),
    },
    modalities={
        "force": Feed((FORCE,)),
        "image": Feed((FRAME,)),
        "image-change": Feed((CHANGE,)),
        "fused-equal": Feed((FRAME, FORCE)),
        "fused-change": Feed((CHANGE, FORCE), weights="chosen"),
        "fused-change-equal": Feed((CHANGE, FORCE)),
        "pixels-change": Feed((PIXELS_CHANGE,), by_name=True),
        "force-series": Feed((SERIES,), by_name=True),
        "fused-pixels-change-equal": Feed((PIXELS_CHANGE, SERIES), by_name=True),
    },
    probes=PROBES,
)
