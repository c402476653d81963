"""The effects of a slip scene, each switched on a trial."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from sensors.explain import Effect, Explanation, Grid, Readings, Run, Switch, measure_switches, rms
from sensors.explain_press import FLAGS, creep_switch, spread
from sensors.fvsight import fvsight_unit
from sensors.slide.membrane import in_plane_skin
from sensors.slide.scene import SlipScene
from sensors.slide.simulate import place_body, simulate_slide
from sensors.slide.track import traction_modes

SLIDE_FLAGS = FLAGS | {
    "crowns": "thread crowns exchange load as the object rides over them",
    "shear_moment": "shear on the film's face loads the taxels ahead of it",
    "late_film": "a share of every change of load arrives late",
}


def explain_slide(
    scene: SlipScene, samples: int = 1, seed: int = 0, advance: Callable[[int], None] = lambda count: None
) -> Explanation:
    """Measure each effect of `scene` on `samples` trials; `advance` gets 1 an effect.

    Frames are not part of the time: a trial stores forces unless frames are asked for.
    """
    indices = spread(scene.n_samples // len(scene.objects), len(scene.objects), samples)
    switches = [
        Switch(Effect(name.replace("_", " "), on, why), _run(_switched(scene, name, not on), seed))
        for name, why in SLIDE_FLAGS.items()
        for on in (getattr(scene.effects, name),)
    ]
    switches.append(creep_switch(scene, lambda other: _run(other, seed)))
    ripple, noise = scene.motion.load_ripple, scene.motion.moving_noise
    still = {"load_ripple": 0.0, "moving_noise": 0.0} if ripple or noise else {"load_ripple": 0.004}
    motion = scene.model_copy(update={"motion": scene.motion.model_copy(update=still)})
    why = "force control is not still"
    switches.append(Switch(Effect("ripple and noise of the load", bool(ripple or noise), why), _run(motion, seed)))
    switches.append(Switch(_weave(scene, indices, seed)))
    cpu_ms, effects = measure_switches(_run(scene, seed), switches, indices, advance)
    sensor = scene.effective_sensor()
    grids = (Grid("skin", sensor.grid, True, None, {}, None),)
    return Explanation(scene.id, len(indices), cpu_ms, tuple(effects), grids=grids)


def n_slide_effects() -> int:
    """How many effects `explain_slide` switches or weighs."""
    return len(SLIDE_FLAGS) + 3


def _switched(scene: SlipScene, name: str, on: bool) -> SlipScene:
    return scene.model_copy(update={"effects": scene.effects.model_copy(update={name: on})})


def _run(scene: SlipScene, seed: int) -> Run:
    def run(index: int) -> Readings:
        return Readings(simulate_slide(scene, index, seed).force_series)

    return run


def _weave(scene: SlipScene, indices: Sequence[int], seed: int) -> Effect:
    """The frame at the largest drag of the skin with its threads left where they lay."""
    errors, moves = [], []
    for index in indices:
        trial = simulate_slide(scene, index, seed, ("skin_shift",))
        shift = trial.truth["skin_shift"]
        x, y = (float(value) for value in shift[int(np.argmax(np.hypot(*shift.T)))])
        plan = scene.plan(index)
        unit = fvsight_unit(scene.effective_sensor(), plan.unit)
        placed = place_body(scene, plan, unit, np.random.default_rng([seed, index]).spawn(5)[0])
        start = placed.solve(0.0, plan.load_n)
        skin = in_plane_skin(unit.grid, unit.skin.film, scene.friction.areal_mass_kg_m2, traction_modes(unit, start))
        camera = unit.camera
        drawn = camera.shift_shape(skin.modes * skin.stiffness)
        clean = camera.clean(unit.observe(start).surface_modes)
        ratio = camera.dragged_weave(drawn, (x, y))
        errors.append(0.0 if ratio is None else rms(clean * ratio - clean))
        moves.append(float(np.hypot(x, y) * drawn.max()) / (unit.grid.size_m / clean.shape[2]))
    why = f"friction drags the threads by up to {max(moves):.2f} pixels; always on where frames are taken"
    return Effect("weave moves along", True, why, frame_levels=float(np.mean(errors)))
