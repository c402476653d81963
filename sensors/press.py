"""One press, simulated: object in place -> contact -> taxels and frame -> Recording."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors import objects
from sensors.contact.solver import NO_SURFACE
from sensors.fvsight import FORCE_RATE_HZ, FVSightUnit, Press, fvsight_unit
from sensors.recording import Recording
from sensors.scene import Motion, Pose, PressScene, SamplePlan, nominal_pose, plan

TRUTH_FIELDS = ("displacement", "pressure", "contact")
_DEEPEST_M = 8e-3
"""Parts of an object further below its top than this are never met: the stretching bound refuses such presses."""
_AIR_M = 2e-4
"""Heights below this are the blurred outline of the object, not the object."""
_HISTORY_LOADS = (0.05, 0.2, 0.5)
"""Shares of the full load at which the load's distribution over the taxels is solved."""


_HISTORY_TOLERANCE = 1e-3
"""The history needs the shares of 16 taxels, not the pressure of every cell."""


def simulate(scene: PressScene, index: int, seed: int, truth: tuple[str, ...] = ()) -> Recording:
    """Sample `index` of a scene; depends on (scene, index, seed) alone.

    `truth` names ground-truth fields to keep, of displacement (surface that the camera sees, m), pressure (Pa) and
    contact (bool), each on the contact grid. Raises ValueError for an unknown field or a press that the sensor refuses.
    """
    unknown = [name for name in truth if name not in TRUTH_FIELDS]
    if unknown:
        raise ValueError(f"unknown truth field {unknown[0]!r}: expected some of {', '.join(TRUTH_FIELDS)}")
    what = plan(scene, index)
    pose_rng, load_rng, force_rng, camera_rng = np.random.default_rng([seed, index]).spawn(4)
    sensor = scene.effective_sensor()
    unit = fvsight_unit(sensor, what.unit)
    session = unit.session(np.random.default_rng([seed, what.unit, what.session, 1]))
    pose = draw_pose(scene.pose, what.label, pose_rng)
    gap = presented_gap(what.object_name, unit, pose, scene.specimen_mm * 1e-3)
    load_n = _draw_load(scene, what, load_rng)
    press = unit.press(gap, load_n)
    scene.keep_bound(press.contact.indentation_m)
    load, hold = load_history(scene.motion, load_n, load_rng)
    series = unit.read(taxel_history(unit, gap, press, load), session, force_rng)
    middle = (hold[0] + hold[1]) // 2
    return Recording(
        image=unit.frame(press.surface_modes, session, camera_rng),
        image_rest=unit.frame(None, session, camera_rng),
        force_series=series,
        rate_hz=FORCE_RATE_HZ,
        force=series[hold[0] : hold[1]].mean(axis=0, dtype=np.float64).astype(np.float32),
        taxel_load=press.taxel_load.astype(np.float32),
        total_force_n=press.contact.force_n,
        indentation_mm=press.contact.indentation_m * 1e3,
        hold=hold,
        image_time_s=middle / FORCE_RATE_HZ,
        labels=_labels(what, seed, pose),
        truth=_truth(unit, press, truth),
    )


def draw_pose(pose: Pose, label: int, rng: np.random.Generator) -> tuple[float, float, float]:
    """Place and angle of one press (mm, mm, deg): nominal, plus re-seating error, plus unknown pose."""
    x, y, turn = nominal_pose(pose, label)
    reseat, jitter = rng.standard_normal(3), rng.uniform(-1, 1, 3)
    return (
        x + pose.reseat_mm * reseat[0] + pose.jitter_mm * jitter[0],
        y + pose.reseat_mm * reseat[1] + pose.jitter_mm * jitter[1],
        turn + pose.reseat_deg * reseat[2] + pose.jitter_deg * jitter[2],
    )


def presented_gap(
    name: str, unit: FVSightUnit, pose: tuple[float, float, float], specimen_m: float
) -> NDArray[np.float32]:
    """Gap (n, n) in metres between the flat skin and the object at first touch; inf where there is no object.

    The object stands on a pedestal smaller than itself, so that the skin meets the object and no table.
    """
    x_m, y_m, angle = pose[0] * 1e-3, pose[1] * 1e-3, np.deg2rad(pose[2])
    return gap_under(objects.place(name, unit.grid.n, unit.grid.size_m, x_m, y_m, angle), unit, (x_m, y_m), specimen_m)


def gap_under(
    height: NDArray[np.floating], unit: FVSightUnit, centre_m: tuple[float, float], specimen_m: float
) -> NDArray[np.float32]:
    """Gap (n, n) in metres between the flat skin and any `height` (n, n; metres above the table) at first touch.

    Parts beyond the disc of diameter `specimen_m` about `centre_m` are cut away, as is the table: inf there.
    ValueError where nothing is left.
    """
    x_m, y_m = centre_m
    axis = unit.grid.axis()
    inside = (axis[None, :] - x_m) ** 2 + (axis[:, None] - y_m) ** 2 <= (specimen_m / 2) ** 2
    there = inside & (height > _AIR_M)
    if not there.any():
        raise ValueError(f"a press needs something under the sensor, found nothing higher than {_AIR_M * 1e3:g} mm")
    top = height[there].max()
    return np.where(there & (top - height < _DEEPEST_M), top - height, NO_SURFACE).astype(np.float32)


def _draw_load(scene: PressScene, what: SamplePlan, rng: np.random.Generator) -> float:
    nominal = scene.load.deep_n if what.press == "deep" else scene.load.shallow_n
    # three standard deviations: a force controller with an alarm repeats a press beyond them
    return float(nominal * (1 + scene.load.spread * np.clip(rng.standard_normal(), -3, 3)))


def load_history(
    motion: Motion, load_n: float, rng: np.random.Generator
) -> tuple[NDArray[np.float64], tuple[int, int]]:
    """Total load (T,) in newtons over approach, hold and release, and the [first, last) sample of the hold."""
    samples = [
        max(1, round(seconds * FORCE_RATE_HZ)) for seconds in (motion.approach_s, motion.hold_s, motion.release_s)
    ]
    up = 0.5 - 0.5 * np.cos(np.pi * np.arange(samples[0]) / samples[0])
    down = 0.5 + 0.5 * np.cos(np.pi * (np.arange(samples[2]) + 1) / samples[2])
    time_s = np.arange(samples[1]) / FORCE_RATE_HZ
    ripple = motion.ripple * np.sin(2 * np.pi * (motion.ripple_hz * time_s + rng.random()))
    profile = np.concatenate((up, 1 + ripple, down))
    return load_n * profile, (samples[0], samples[0] + samples[1])


def taxel_history(
    unit: FVSightUnit, gap: NDArray[np.floating], press: Press, load: NDArray[np.float64]
) -> NDArray[np.float64]:
    """True taxel loads (T, 16) in newtons under a history of total load (T,), with a few solves.

    How the load spreads over the taxels is solved at a few loads, each from the last, and interpolated linearly in the
    load, which keeps their sum.
    """
    full = press.contact.force_n
    levels, shares = [full], [press.taxel_load / full]
    pressure = press.contact.pressure
    for part in reversed(_HISTORY_LOADS):
        lighter = unit.press(gap, part * full, initial=pressure, tolerance=_HISTORY_TOLERANCE)
        pressure = lighter.contact.pressure
        levels.append(part * full)
        shares.append(lighter.taxel_load / lighter.contact.force_n)
    share = np.stack([np.interp(load, levels[::-1], column) for column in np.stack(shares[::-1], axis=1)], axis=1)
    return share * load[:, None]


def _labels(what: SamplePlan, seed: int, pose: tuple[float, float, float]) -> dict[str, Any]:
    return {
        "id": f"{what.index:06d}",
        "object": what.object_name,
        "label": what.label,
        "press": what.press,
        "unit": what.unit,
        "session": what.session,
        "round": what.round,
        "seed": seed,
        "pose_x_mm": float(pose[0]),
        "pose_y_mm": float(pose[1]),
        "pose_deg": float(pose[2]),
    }


def _truth(unit: FVSightUnit, press: Press, names: tuple[str, ...]) -> Mapping[str, NDArray[Any]]:
    def field(name: str) -> NDArray[Any]:
        if name == "displacement":
            return unit.surface(press.surface_modes)
        return press.contact.pressure if name == "pressure" else press.contact.contact

    return {name: field(name) for name in names}
