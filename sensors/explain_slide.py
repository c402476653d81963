"""The effects of a slip scene, each switched on a trial."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from sensors.explain import Effect, Explanation, Readings, Run, Switch, measure_switches, rms
from sensors.explain_grids import SLIDES, slide_grids, slide_warning
from sensors.explain_press import FLAGS, creep_switch, spread
from sensors.fvsight import fvsight_unit
from sensors.slide.scene import UNSHEARED, SlipScene
from sensors.slide.simulate import dragged_skin, place_body, simulate_slide

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
    switches.append(_partial_slip(scene, indices, seed))
    cpu_ms, effects = measure_switches(_run(scene, seed), switches, indices, advance)
    if switches[-1].run is not None:
        effects[-1] = replace(effects[-1], frame_levels=switches[-1].effect.frame_levels)
    models = "; ".join(filter(None, (SLIDES, slide_warning(scene))))
    return Explanation(scene.id, len(indices), cpu_ms, tuple(effects), grids=slide_grids(scene), models=models)


def n_slide_effects() -> int:
    """How many effects `explain_slide` switches or weighs."""
    return len(SLIDE_FLAGS) + 4


def _switched(scene: SlipScene, name: str, on: bool) -> SlipScene:
    return scene.model_copy(update={"effects": scene.effects.model_copy(update={name: on})})


def _run(scene: SlipScene, seed: int) -> Run:
    def run(index: int) -> Readings:
        return Readings(simulate_slide(scene, index, seed).force_series)

    return run


def _partial_slip(scene: SlipScene, indices: Sequence[int], seed: int) -> Switch:
    """Cell by cell or as one patch: when the contact lets go, and the frame that differs most."""
    name, on = "partial slip", scene.effects.partial_slip
    if scene.sensor.support == "hollow":
        return Switch(Effect(name, False, "a hollow skin moves as one patch; solved for a film on a plate alone"))
    if others := [kind for kind in scene.protocol.kinds if kind in UNSHEARED]:
        return Switch(Effect(name, False, f"not worked out for {', '.join(others)}"))
    still = _switched(scene, "camera_noise", False)
    frames, later = [], []
    for index in indices:
        cells, patch = (
            simulate_slide(_switched(still, "partial_slip", each), index, seed, frames=True) for each in (True, False)
        )
        if cells.frames is None or patch.frames is None:
            continue
        pairs = zip(cells.frames, patch.frames, strict=True)
        frames.append(max(rms(one.astype(np.float64) - other) for one, other in pairs))
        if cells.onset_sample is not None and patch.onset_sample is not None:
            later.append((cells.onset_sample - patch.onset_sample) / cells.rate_hz * 1e3)
    why = "the film shears and slips cell by cell, from the rim inwards"
    if later:
        why += f"; gross slip comes {np.mean(later):+.0f} ms from where one patch has it"
    effect = Effect(name, on, why, frame_levels=float(np.mean(frames)))
    return Switch(effect, _run(_switched(scene, name.replace(" ", "_"), not on), seed))


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
        skin, _ = dragged_skin(scene, unit, start)
        camera = unit.camera
        drawn = camera.shift_shape(skin.modes * skin.stiffness)
        clean = camera.clean(unit.observe(start).surface_modes)
        ratio = camera.dragged_weave(drawn, (x, y))
        errors.append(0.0 if ratio is None else rms(clean * ratio - clean))
        moves.append(float(np.hypot(x, y) * drawn.max()) / (unit.grid.size_m / clean.shape[2]))
    why = f"friction drags the threads by up to {max(moves):.2f} pixels; always on where frames are taken"
    return Effect("weave moves along", True, why, frame_levels=float(np.mean(errors)))
