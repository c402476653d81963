"""The effects of a press scene, each switched on a few presses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from sensors.contact.ladder.finite_strain import linear_error
from sensors.contact.large_deflection import linear_excess
from sensors.explain import Effect, Explanation, Readings, Run, Switch, measure_switches, rms
from sensors.explain_grids import MODELS, press_grids
from sensors.fvsight import FVSightUnit, Press, fvsight_unit
from sensors.optics.horizon import horizon_elevation
from sensors.optics.lights import LedRing
from sensors.press import draw_pose, presented_gap, simulate
from sensors.scene import PressScene, plan
from sensors.slide.scene import SlipScene
from sensors.timing import WARM, press_stages

AnyScene = TypeVar("AnyScene", PressScene, SlipScene)

SAMPLES = 4
FLAGS = {
    "unit_spread": "sensors of one kind differ: tension, gains, LEDs, camera, threads",
    "session_drift": "gains, offsets and light drift between sessions",
    "force_noise": "electronic noise before the ADC",
    "camera_noise": "shot and read noise of the pixels",
    "hysteresis": "the film remembers its loading",
}
_STILL_PX = 0.25
"""Threads that move less than this may stand still in the frame."""


def explain_press(
    scene: PressScene, samples: int = SAMPLES, seed: int = 0, advance: Callable[[int], None] = lambda count: None
) -> Explanation:
    """Measure each effect of `scene` on `samples` presses, spread over its objects; `advance` gets 1 an effect."""
    indices = spread(scene.n_samples // len(scene.object_names), len(scene.object_names), samples)
    switches = _switches(scene, indices, seed)
    cpu_ms, effects = measure_switches(_run(scene, seed), switches, indices, advance)
    return Explanation(
        scene.id,
        len(indices),
        cpu_ms,
        tuple(effects),
        _stages(scene, indices, seed),
        press_grids(scene),
        MODELS[scene.sensor.support],
    )


def n_effects(scene: PressScene) -> int:
    """How many effects `explain_press` switches or weighs."""
    return len(FLAGS) + (10 if scene.sensor.support == "hollow" else 11)


def spread(passes: int, objects: int, samples: int) -> list[int]:
    """Up to `samples` indices of a protocol of `passes` over `objects`, spread over both."""
    if samples < 1:
        raise ValueError(f"samples must be >= 1, got {samples}")
    samples = min(samples, passes * objects)
    return sorted({i * passes // samples * objects + i * objects // samples for i in range(samples)})


def _run(scene: PressScene, seed: int) -> Run:
    def run(index: int) -> Readings:
        made = simulate(scene, index, seed, ("displacement",))
        return Readings(made.force_series, made.image, made.truth["displacement"])

    return run


def _switches(scene: PressScene, indices: Sequence[int], seed: int) -> list[Switch]:
    def varied(name: str, on: bool, why: str, part: str | None, **changes: Any) -> Switch:
        changed = changes if part is None else {part: getattr(scene, part).model_copy(update=changes)}
        return Switch(Effect(name, on, why), _run(scene.model_copy(update=changed), seed))

    sensor = scene.sensor
    switches = [
        varied(name.replace("_", " "), on, why, "effects", **{name: not on})
        for name, why in FLAGS.items()
        for on in (getattr(scene.effects, name),)
    ]
    switches += [
        varied("re-seating", scene.pose.reseat_mm + scene.pose.reseat_deg > 0, "objects are put back by hand", "pose",
               reseat_mm=0.0 if scene.pose.reseat_mm else 0.5, reseat_deg=0.0 if scene.pose.reseat_deg else 1.0),
        varied("load spread", scene.load.spread > 0, "a force controller repeats a load within this", "load",
               spread=0.0 if scene.load.spread else 0.03),
        varied("ripple of the arm", scene.motion.ripple > 0, "force control is not still", "motion",
               ripple=0.0 if scene.motion.ripple else 0.004),
        creep_switch(scene, lambda other: _run(other, seed)),
        varied("bare sheet", sensor.taxels == "velostat", "a velostat creeps, remembers and varies from press to press",
               "sensor", taxels="fvsight" if sensor.taxels == "velostat" else "velostat"),
        varied("ghosts of floating rows", sensor.scanning != "isolated", "isolated scanning has no crosstalk",
               "sensor", scanning="isolated" if sensor.scanning != "isolated" else "floating"),
    ]  # fmt: skip
    presses = [_press(scene, index, seed) for index in indices]
    switches += [Switch(_weave(scene, presses)), Switch(_shadows(presses)), Switch(_stretching(scene, presses))]
    if scene.sensor.support == "plate":
        switches.append(Switch(_finite_strain(scene, presses)))
    switches.append(Switch(Effect("specular light", False, "canvas is matt: only gels need it")))
    return switches


def creep_switch(scene: AnyScene, run: Callable[[AnyScene], Run]) -> Switch:
    """The creep of the taxels; of the bare sheet in this scene where the scene's own taxels have none."""
    sheet = scene.model_copy(update={"sensor": scene.sensor.model_copy(update={"taxels": "velostat"})})

    def switched(on: bool) -> Run:
        return run(sheet.model_copy(update={"effects": sheet.effects.model_copy(update={"creep": on})}))

    name = "creep and overshoot"
    if scene.sensor.taxels == "velostat" and scene.sensor.creep:
        on = scene.effects.creep
        return Switch(Effect(name, on, "conductance grows on a hold and dips at release"), switched(not on))
    why = "the taxels of this scene have none; shown: of a bare sheet (taxels: velostat) in it"
    return Switch(Effect(name, False, why), switched(True), switched(False))


def _press(scene: PressScene, index: int, seed: int) -> tuple[FVSightUnit, Press]:
    what = plan(scene, index)
    unit = fvsight_unit(scene.effective_sensor(), what.unit)
    rng = np.random.default_rng([seed, index]).spawn(4)[0]
    gap = presented_gap(what.object_name, unit, draw_pose(scene.pose, what.label, rng), scene.specimen_mm * 1e-3)
    return unit, unit.press(gap, scene.load.deep_n if what.press == "deep" else scene.load.shallow_n)


def _weave(scene: PressScene, presses: Sequence[tuple[FVSightUnit, Press]]) -> Effect:
    """Threads move along with the inner face: half the film's thickness times its slope."""
    errors, moves = [], []
    for unit, press in presses:
        camera = unit.camera
        clean = camera.clean(press.surface_modes)
        across, down = camera.slopes(press.surface_modes)
        half = -scene.sensor.film_thickness_mm * 1e-3 / 2
        ratios = [camera.dragged_weave(across, (half, 0.0)), camera.dragged_weave(down, (0.0, half))]
        moved = clean
        for ratio in ratios:
            moved = moved if ratio is None else moved * ratio
        errors.append(rms(moved - clean))
        pixel = unit.grid.size_m / clean.shape[1]
        moves.append(float(np.hypot(across, down).max()) * abs(half) / pixel)
    verdict = "beyond" if max(moves) > _STILL_PX else "within"
    why = (
        f"threads would move by {max(moves):.2f} pixels at most, {verdict} the {_STILL_PX:g} that need no moving weave"
    )
    return Effect("weave moves along", False, why, frame_levels=float(np.mean(errors)))


def _shadows(presses: Sequence[tuple[FVSightUnit, Press]]) -> Effect:
    """Light of each arc taken away where the surface's horizon stands above the arc's middle."""
    ring, errors, steepest = LedRing(), [], 0.0
    for unit, press in presses:
        clean = unit.camera.clean(press.surface_modes)
        rows, columns = clean.shape[1:]
        pixel = unit.grid.size_m / columns
        surface = unit.camera.shift_shape(press.surface_modes) / pixel
        axis = (np.arange(columns) + 0.5) / columns * unit.grid.size_m - unit.grid.size_m / 2
        shaded = clean.copy()
        for channel, azimuth in enumerate(np.deg2rad(ring.azimuths_deg)):
            horizon = horizon_elevation(surface, float(azimuth), rows / 2)
            x, y = ring.radius_m * np.cos(azimuth), ring.radius_m * np.sin(azimuth)
            light = np.arctan2(ring.height_m, np.hypot(x - axis[None, :], y - axis[:rows, None]))
            steepest = max(steepest, float(np.rad2deg(horizon.max())))
            shaded[channel][horizon > light] = 0
        errors.append(rms(shaded - clean))
    lowest = np.rad2deg(np.arctan2(ring.height_m, ring.radius_m + presses[0][0].grid.size_m / np.sqrt(2)))
    why = f"the surface rises by {steepest:.1f} deg at most, the lowest light stands at {lowest:.1f} deg"
    return Effect("shadows", False, why, frame_levels=float(np.mean(errors)))


def _stretching(scene: PressScene, presses: Sequence[tuple[FVSightUnit, Press]]) -> Effect:
    """How much too deep the linear skin sinks, by the von Karman disc under a patch as large as the contact."""
    if scene.sensor.support != "hollow":
        return Effect("stretching of the skin", False, "a pad on a plate spans nothing")
    unit, deepest = max(presses, key=lambda one: one[1].contact.indentation_m)
    x, y = unit.grid.coordinates()
    touched = deepest.contact.contact
    patch = float(np.hypot(x[touched] - x[touched].mean(), y[touched] - y[touched].mean()).max())
    half = unit.grid.size_m / 2
    excess = linear_excess(unit.skin, half, min(max(patch, 1e-3), 0.9 * half), deepest.contact.force_n)
    why = f"the linear skin sinks {excess:.1%} too deep at most here; a press beyond the bound "
    why += f"of {scene.sensor.stretching_bound:.0%} is refused"
    return Effect("stretching of the skin", False, why, surface_um=excess * deepest.contact.indentation_m * 1e6)


def _finite_strain(scene: PressScene, presses: Sequence[tuple[FVSightUnit, Press]]) -> Effect:
    """The linear film against the hyperelastic one: the ladder's classes of indenter stand for the objects."""
    ratio = max(press.contact.indentation_m for _, press in presses) / (scene.sensor.film_thickness_mm * 1e-3)
    try:
        off = linear_error(ratio, scene.sensor.film_poisson)
        why = f"pressed to {ratio:.2f} of its thickness; the linear layer's force is up to {off.force:.1%} off at "
        why += f"{off.depth_ratio:g}" + ("; the error bound counts it" if scene.error_bound else "")
    except ValueError as error:
        why = str(error)
    return Effect("finite strain of the film", False, why)


def _stages(scene: PressScene, indices: Sequence[int], seed: int) -> dict[str, float]:
    unit = fvsight_unit(scene.effective_sensor(), 0)
    found = []
    for index in indices:
        what = plan(scene, index)
        found.append(press_stages(scene, unit, what.object_name, what.label, np.random.default_rng([seed, index])))
    return {stage: float(np.median([one[stage] for one in found])) for stage in found[0] if stage != WARM}
