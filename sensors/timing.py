"""What one paired press frame costs, stage by stage, and one second of friction and electronics."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from sensors.electronics.piezoresistive import PiezoresistiveChain
from sensors.friction.lugre import LuGre
from sensors.fvsight import FORCE_RATE_HZ, TAXELS_PER_SIDE, FVSightParameters, FVSightUnit, fvsight_unit
from sensors.press import draw_pose, load_history, presented_gap, taxel_history
from sensors.scene import PressScene
from sensors.slip_timing import measure_slip_frame

_T = TypeVar("_T")

CONFIGURATIONS: dict[str, FVSightParameters] = {
    "fvsight, skin 128x128": FVSightParameters(),
    "pad on a plate, layer 64x64": FVSightParameters(
        support="plate", grid=64, film_thickness_mm=4.0, film_modulus_mpa=0.3
    ),
}
TAXELS, TAXEL_STAGES = "16 taxels, 1 s at 1 kHz", ("friction", "electronics", "both")
_TAXEL_ROUNDS = 30
WARM, _WARM_FROM = "contact, warm", 0.95
"""A solve that starts from the solution under this share of the load, as along an indentation path."""
STAGES = ("place", "contact", "taxels", "render", "frame total", "force history", WARM)
SLIP = "slip frame, skin 128x128"


def frame_cost(repeats: int = 3, seed: int = 0) -> list[dict[str, Any]]:
    """CPU milliseconds of one paired press frame on one thread, for each sensor configuration and stage.

    Presses all 27 objects `repeats` times with fresh poses after a warm-up; rows hold sensor, stage, ms_p50, ms_p95,
    ms_max and n. `frame total` is place + contact + taxels + render (no encoding); the force history of a press, with
    its further solves and its electronics, is apart; so is a warm contact solve. The rows of `SLIP` are a frame of a
    slip trial with its share of the trial's forces, a trial a repeat. The rows of `TAXELS` are one second of LuGre
    friction in the plane and of the piezoresistive chain for 16 taxels, `_TAXEL_ROUNDS` times a repeat.
    """
    if repeats < 1:
        raise ValueError(f"repeats must be >= 1, got {repeats}")
    with threadpool_limits(1):
        rows = [
            row
            for name, parameters in CONFIGURATIONS.items()
            for row in _rows(name, _measure(parameters, repeats, seed))
        ]
        rows += _rows(SLIP, measure_slip_frame(repeats, seed))
        return rows + _rows(TAXELS, _measure_taxels(_TAXEL_ROUNDS * repeats, seed))


def _measure(parameters: FVSightParameters, repeats: int, seed: int) -> dict[str, list[float]]:
    scene = PressScene(id="timing", title="timing", sensor=parameters)
    unit = fvsight_unit(parameters, 0)
    spent: dict[str, list[float]] = {stage: [] for stage in STAGES}
    for round_number in range(repeats + 1):
        for label, name in enumerate(scene.object_names):
            sample = press_stages(scene, unit, name, label, np.random.default_rng([seed, round_number, label]))
            if round_number > 0:  # the first round warms the caches
                for stage, milliseconds in sample.items():
                    spent[stage].append(milliseconds)
    return spent


def press_stages(
    scene: PressScene, unit: FVSightUnit, name: str, label: int, rng: np.random.Generator
) -> dict[str, float]:
    """CPU milliseconds of each of `STAGES` of one press; `label` is the object's number in the scene."""
    spent: dict[str, float] = {}
    session = unit.session(rng)
    pose = draw_pose(scene.pose, label, rng)
    gap = _timed(spent, "place", lambda: presented_gap(name, unit, pose, scene.specimen_mm * 1e-3))
    contact = _timed(spent, "contact", lambda: unit.solve(gap, scene.load.deep_n))
    press = _timed(spent, "taxels", lambda: unit.observe(contact))
    _timed(spent, "render", lambda: unit.frame(press.surface_modes, session, rng))
    spent["frame total"] = sum(spent.values())

    def history() -> None:
        load, _ = load_history(scene.motion, scene.load.deep_n, rng)
        unit.read(taxel_history(unit, gap, press, load), session, rng)

    _timed(spent, "force history", history)
    start = unit.solve(gap, _WARM_FROM * scene.load.deep_n).pressure
    _timed(spent, WARM, lambda: unit.solve(gap, scene.load.deep_n, start))
    return spent


def _measure_taxels(rounds: int, seed: int) -> dict[str, list[float]]:
    rng = np.random.default_rng(seed)
    chain, law = PiezoresistiveChain(), LuGre(np.full(TAXELS_PER_SIDE**2, 2e4), damping=0.3, viscosity=0.4)
    time_s = np.arange(round(FORCE_RATE_HZ)) / FORCE_RATE_HZ
    swing = np.sin(2 * np.pi * time_s[:, None] * rng.uniform(0.5, 3, TAXELS_PER_SIDE**2))
    load = 2 + swing
    velocity = 0.02 * np.stack((swing, 1 - swing**2), axis=-1)
    spent: dict[str, list[float]] = {stage: [] for stage in TAXEL_STAGES}
    for round_number in range(rounds + 1):
        sample: dict[str, float] = {}
        _timed(sample, "friction", lambda: law.follow(velocity, load, 1 / FORCE_RATE_HZ))
        _timed(sample, "electronics", lambda: chain.read(load, rng))
        sample["both"] = sum(sample.values())
        if round_number > 0:  # the first round compiles
            for stage, milliseconds in sample.items():
                spent[stage].append(milliseconds)
    return spent


def _timed(spent: dict[str, float], stage: str, work: Callable[[], _T]) -> _T:
    start = time.process_time_ns()
    result = work()
    spent[stage] = (time.process_time_ns() - start) / 1e6
    return result


def _rows(name: str, spent: dict[str, list[float]]) -> list[dict[str, Any]]:
    return [
        {
            "sensor": name,
            "stage": stage,
            "ms_p50": float(np.median(values)),
            "ms_p95": float(np.percentile(values, 95)),
            "ms_max": float(max(values)),
            "n": len(values),
        }
        for stage, values in spent.items()
    ]
