"""Presses of training shapes on sensors of their own: simulated once, kept by unit, same bytes from the same seed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors.fvsight import FVSightParameters, FVSightUnit
from sensors.press import gap_under
from vtbench.data.files import make_folder, write_whole
from vtbench.run.progress import bar
from vtbench.tasks.presses import averaged, change
from vtbench.training.shapes import shape

RECIPE_VERSION = 1
"""Raised when the presses of a seed change."""
SPECIMEN_M = 56e-3
POOL = 4
"""Side of the squares over which the network averages a frame first; training presses are kept as those sums."""
MAP_SIDE = 32
SENSOR = FVSightParameters(
    tension_spread=0.1,
    led_power_spread=0.16,
    led_azimuth_spread_deg=6.0,
    camera_offset_mm=1.0,
    session_light_drift=0.04,
)
"""Units spread twice as wide as those of the tasks, so that a new one lies among them."""
FIRST_UNIT, FIRST_VALIDATION_UNIT, FIRST_VALIDATION_SHAPE = 1000, 9000, 100_000
"""Tasks count their units from 0; training and validation share neither units nor shapes."""


@dataclass(frozen=True)
class TrainingPlan:
    """Which presses are simulated for training.

    Attributes:
        seed: draws poses, loads, sessions and noise.
        presses: how many.
        shapes: how many shapes are pressed, in pairs of twins.
        per_unit: presses of one sensor unit.
        offset_mm, load_n: place of a shape, uniform within +- this on each axis; load, log-uniform between these.
    """

    seed: int = 0
    presses: int = 9000
    shapes: int = 400
    per_unit: int = 60
    offset_mm: float = 10.0
    load_n: tuple[float, float] = (1.0, 7.0)

    @property
    def units(self) -> int:
        """Number of sensor units, the last perhaps with fewer presses."""
        return -(-self.presses // self.per_unit)


@dataclass(frozen=True)
class ValidationPlan:
    """Presses that say how well features tell unseen shapes apart on unseen units.

    Each unit presses each shape `same_pose` times re-seated in one pose of the shape (0.5 mm, 1 degree) and `any_pose`
    times anywhere; every third press is light.
    """

    seed: int = 0
    shapes: int = 40
    units: int = 4
    same_pose: int = 3
    any_pose: int = 4
    offset_mm: float = 8.0
    load_n: tuple[float, float] = (5.0, 1.5)


Arrays = dict[str, NDArray[Any]]
Pose = tuple[float, float, float]


def training_presses(plan: TrainingPlan, folder: Path, jobs: int = 1, progress: bool = False) -> Arrays:
    """The presses of a plan, simulated where `folder` does not hold them yet.

    Returns:
        `frame`, `change` (n, 3, 64, 64) uint16: sums of grey levels over squares of 4 x 4 pixels; `pressure` (kPa) and
        `displacement` (mm) (n, 32, 32) float16 averaged over cells; `shape` (n,) int64 from 0.
    """
    recipe = {**asdict(plan), "presses": None}  # a longer plan goes on with the units of a shorter one
    at = _home(folder, "training", recipe)
    parts = _kept(at, plan.units, partial(_training_unit, plan), jobs, progress, "training presses", plan.per_unit)
    joined = {name: np.concatenate([part[name] for part in parts])[: plan.presses] for name in parts[0]}
    return joined


def validation_presses(plan: ValidationPlan, folder: Path, jobs: int = 1, progress: bool = False) -> Arrays:
    """The presses of a validation plan: `frame`, `change` (n, 256, 256, 3) uint8, `shape`, `unit`, `any_pose` (n,)."""
    at = _home(folder, "validation", asdict(plan))
    each = plan.shapes * (plan.same_pose + plan.any_pose)
    parts = _kept(at, plan.units, partial(_validation_unit, plan), jobs, progress, "validation presses", each)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def data_sha256(arrays: Arrays) -> str:
    """SHA-256 over the bytes of presses, array by array in the order of their names."""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        digest.update(name.encode() + np.ascontiguousarray(arrays[name]).tobytes())
    return digest.hexdigest()


def press_shape(
    unit: FVSightUnit,
    number: int,
    pose: Pose,
    load_n: float,
    rng: np.random.Generator,
    session_rng: np.random.Generator,
) -> Arrays:
    """One press: `frame`, `rest` (256, 256, 3) uint8, `pressure` (Pa), `displacement` (m) (grid, grid).

    A load under which the sensor refuses the shape, because it would sink too deep, is lowered by a quarter until not.
    """
    height = shape(number).placed(unit.grid.n, unit.grid.size_m, pose)
    gap = gap_under(height, unit, (pose[0] * 1e-3, pose[1] * 1e-3), SPECIMEN_M)
    while True:
        try:
            press = unit.press(gap, load_n)
            break
        except ValueError:
            load_n *= 0.75
    session = unit.session(session_rng)
    return {
        "frame": unit.frame(press.surface_modes, session, rng),
        "rest": unit.frame(None, session, rng),
        "pressure": press.contact.pressure,
        "displacement": unit.surface(press.surface_modes),
    }


def pooled(frame: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Sums (3, rows / 4, columns / 4) of a frame (rows, columns, 3) over its squares."""
    rows, columns, _ = frame.shape
    squares = frame.reshape(rows // POOL, POOL, columns // POOL, POOL, 3)
    return squares.sum(axis=(1, 3), dtype=np.uint16).transpose(2, 0, 1)


def _training_unit(plan: TrainingPlan, number: int) -> Arrays:
    unit = _unit(FIRST_UNIT + number)
    rows: list[Arrays] = []
    for i in range(number * plan.per_unit, (number + 1) * plan.per_unit):
        rng = np.random.default_rng([plan.seed, i])
        round_number, position = divmod(i, plan.shapes)
        chosen = int(np.random.default_rng([plan.seed, round_number, 1]).permutation(plan.shapes)[position])
        x, y, turn = rng.uniform(-1, 1, 3)
        load = float(np.exp(rng.uniform(*np.log(plan.load_n))))
        pose = (float(x * plan.offset_mm), float(y * plan.offset_mm), float(180 * turn))
        press = press_shape(unit, chosen, pose, load, rng, np.random.default_rng([plan.seed, i // 10, 2]))
        rows.append(
            {
                "frame": pooled(press["frame"]),
                "change": pooled(change(press["frame"], press["rest"])),
                "pressure": _map(press["pressure"] * 1e-3),
                "displacement": _map(press["displacement"] * 1e3),
                "shape": np.asarray(chosen, np.int64),
            }
        )
    return {name: np.stack([row[name] for row in rows]) for name in rows[0]}


def _validation_unit(plan: ValidationPlan, number: int) -> Arrays:
    unit = _unit(FIRST_VALIDATION_UNIT + number)
    rows: list[Arrays] = []
    for k in range(plan.shapes):
        home = np.random.default_rng([plan.seed, k, 3]).uniform(-1, 1, 3) * (plan.offset_mm, plan.offset_mm, 180)
        for j in range(plan.same_pose + plan.any_pose):
            rng = np.random.default_rng([plan.seed, number, k, j])
            anywhere = j >= plan.same_pose
            spread = rng.uniform(-1, 1, 3) * (plan.offset_mm, plan.offset_mm, 180)
            pose = spread if anywhere else home + rng.standard_normal(3) * (0.5, 0.5, 1.0)
            load = plan.load_n[j % 3 == 2] * (1 + 0.03 * float(np.clip(rng.standard_normal(), -3, 3)))
            where = (float(pose[0]), float(pose[1]), float(pose[2]))
            session = np.random.default_rng([plan.seed, number, j, 4])
            press = press_shape(unit, FIRST_VALIDATION_SHAPE + k, where, load, rng, session)
            rows.append(
                {
                    "frame": press["frame"],
                    "change": change(press["frame"], press["rest"]),
                    "shape": np.asarray(k, np.int64),
                    "unit": np.asarray(number, np.int64),
                    "any_pose": np.asarray(anywhere),
                }
            )
    return {name: np.stack([row[name] for row in rows]) for name in rows[0]}


def _map(field: NDArray[np.floating]) -> NDArray[np.float16]:
    return averaged(field[None], MAP_SIDE).reshape(MAP_SIDE, MAP_SIDE).astype(np.float16)


@lru_cache(maxsize=1)
def _unit(number: int) -> FVSightUnit:
    return FVSightUnit(SENSOR, number)


def _home(folder: Path, kind: str, recipe: dict[str, object]) -> Path:
    """Folder of the presses of one recipe."""
    whole = {"version": RECIPE_VERSION, "kind": kind, "sensor": SENSOR.model_dump(mode="json"), **recipe}
    name = hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()[:16]
    return folder / f"{kind}-{name}"


def _kept(
    at: Path, units: int, make: Callable[[int], Arrays], jobs: int, progress: bool, label: str, each: int
) -> list[Arrays]:
    """Arrays of every unit, read where they are kept, else simulated and kept; a killed run goes on where it was."""
    from joblib import Parallel, delayed, parallel_config

    make_folder(at)
    missing = [number for number in range(units) if not _file(at, number).is_file()]
    backend = {"backend": "loky", "inner_max_num_threads": 1} if jobs > 1 else {"backend": "sequential"}
    with bar(len(missing) * each, label, progress) as advance, parallel_config(**backend):
        done: Iterator[None] = Parallel(n_jobs=jobs, return_as="generator_unordered" if jobs > 1 else "generator")(
            delayed(_make)(at, number, make) for number in missing
        )
        for _ in done:
            advance(each)
    parts = []
    for number in range(units):
        with np.load(_file(at, number), allow_pickle=False) as kept:
            parts.append(dict(kept))
    return parts


def _make(at: Path, number: int, make: Callable[[int], Arrays]) -> None:
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):  # a product of several threads rounds otherwise
        write_whole(_file(at, number), partial(_save, make(number)))


def _save(arrays: Arrays, path: Path) -> None:
    with path.open("wb") as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]


def _file(at: Path, number: int) -> Path:
    return at / f"unit-{number:04d}.npz"
