"""One trial of a slip scene, simulated: contact along the path -> friction -> taxels and frames -> SlideRecording."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors.contact.layer import LayerMaterial
from sensors.contact.solver import ContactSolution
from sensors.fvsight import FORCE_RATE_HZ, FVSightUnit, fvsight_unit
from sensors.optics.canvas import Canvas
from sensors.slide.crowns import Crowns
from sensors.slide.drag import Drag, drag, presliding_distance, skin_patch, slip_states
from sensors.slide.footprint import Footprint
from sensors.slide.membrane import InPlaneSkin, in_plane_pad, in_plane_skin
from sensors.slide.partial_slip import shear_film
from sensors.slide.path import Path
from sensors.slide.recording import GROSS, STICK, SlideRecording
from sensors.slide.scene import SlidePlan, SlipScene
from sensors.slide.script import Script, write_script
from sensors.slide.sensing import patch_weave, read_taxels, sheared_weave, take_frames
from sensors.slide.shapes import body
from sensors.slide.track import CELL_M, Placed, Track, lay_track, traction_modes

Array = NDArray[np.float64]

SLIDE_TRUTH = ("taxel_load", "shear_force", "slip_distance", "slip_share", "stick_ratio", "skin_shift", "pose")
_RING_DOWN_S = 0.15
"""After the last motion the skin swings for tens of milliseconds; from then on it rests."""


def simulate_slide(
    scene: SlipScene, index: int, seed: int, truth: tuple[str, ...] = (), frames: bool = False
) -> SlideRecording:
    """Trial `index` of a scene; depends on (scene, index, seed) alone, and its forces not on `truth` or `frames`.

    `truth` names histories to keep, of `SLIDE_TRUTH`; `frames` adds the camera's frames at 30 Hz. Raises ValueError for
    an unknown name, a negative index, or a load that the skin's linear model refuses.
    """
    unknown = [name for name in truth if name not in SLIDE_TRUTH]
    if unknown:
        raise ValueError(f"unknown truth field {unknown[0]!r}: expected some of {', '.join(SLIDE_TRUTH)}")
    plan = scene.plan(index)
    place_rng, script_rng, surface_rng, force_rng, camera_rng = np.random.default_rng([seed, index]).spawn(5)
    unit = fvsight_unit(scene.effective_sensor(), plan.unit)
    session = unit.session(np.random.default_rng([seed, plan.unit, plan.session, 1]))
    placed = place_body(scene, plan, unit, place_rng)
    load_spread, grip_spread = np.clip(place_rng.standard_normal(2), -3, 3)
    load_n = float(plan.load_n * (1 + scene.conditions.load_spread * load_spread))
    grip = float(1 + scene.friction.spread * grip_spread)

    start = placed.solve(0.0, load_n)
    skin, film_beside = dragged_skin(scene, unit, start)
    still = lay_track(placed, np.zeros(1), np.full(1, load_n), start)
    at_rest = skin_patch(scene.friction, film_beside, skin, still.cells, grip)
    presliding = presliding_distance(at_rest, still.cell_share[0] * load_n, scene.friction.gross_share)
    script = write_script(scene, plan, load_n, presliding, script_rng)
    track = lay_track(placed, script.travel, script.load, start, frames)

    first, last = _window(script)
    travel, load = script.travel[first:last], script.load[first:last]
    crowns = Crowns.draw(track.cells.area, placed.body.crown_contrast, Canvas().thread_pitch_m, surface_rng)
    riding = crowns if scene.effects.crowns else None
    sheared = None
    if scene.effects.partial_slip:
        smooth = track.cell_load(travel, load)
        sheared = shear_film(placed, scene.friction, track.cells, travel, load, smooth, grip, presliding)
        pieces: Iterable[Drag] = [sheared.drag(smooth, riding)]
    else:
        patch = skin_patch(scene.friction, film_beside, skin, track.cells, grip)
        pieces = drag(patch, scene.friction, track, placed.path, travel, load, riding)
    history = _history(scene, unit, placed.path, track, pieces, travel)

    # samples before and after the window repeat its ends
    at = np.clip(np.arange(len(script.load)) - first, 0, last - first - 1)
    shift = history.skin_shift[at]
    relative_load = script.load / np.maximum(load[at], 1e-9)
    # the base of a film on a plate stays where it is
    over = script.travel if film_beside is None else _travel_over_skin(placed.path, script, shift)
    taxels = track.taxel_load(over, script.load) + (history.taxel_change[at] * relative_load[:, None])
    state = slip_states(scene.friction, history.slip_share)[at]
    state[: first + 1] = state[last:] = STICK
    onset = np.flatnonzero(state == GROSS)
    times, pictures = np.empty(0), None
    if frames:
        weave = patch_weave(unit, skin, shift) if sheared is None else sheared_weave(unit, sheared, at)
        times, pictures = take_frames(unit, session, track, script, weave, camera_rng)
    film = scene.film if scene.effects.late_film else None
    return SlideRecording(
        force_series=read_taxels(unit, session, film, taxels, script.gain, force_rng),
        rate_hz=FORCE_RATE_HZ,
        state=state,
        onset_sample=int(onset[0]) if len(onset) else None,
        labels=plan.labels(seed),
        frames=pictures,
        frame_time_s=times,
        truth=_truth(truth, taxels, history, at, placed.path, script),
    )


def dragged_skin(
    scene: SlipScene, unit: FVSightUnit, contact: ContactSolution
) -> tuple[InPlaneSkin, LayerMaterial | None]:
    """What friction drags as one patch, and the film that shears beside it: on a plate the film is the patch (None)."""
    film, mass = unit.skin.film, scene.friction.areal_mass_kg_m2
    if scene.sensor.support == "plate":
        return in_plane_pad(film, mass, contact), None
    return in_plane_skin(unit.grid, film, mass, traction_modes(unit, contact)), film


def place_body(scene: SlipScene, plan: SlidePlan, unit: FVSightUnit, rng: np.random.Generator) -> Placed:
    """The trial's object with its tilt on its path over `unit`; draws from `rng`."""
    x, y, turn = rng.uniform(-1, 1, 3)
    placing = scene.placing
    tilt = np.deg2rad(placing.tilt_deg) * np.clip(rng.standard_normal(2), -3, 3)
    path = Path(
        float(x * placing.offset_mm * 1e-3),
        float(y * placing.offset_mm * 1e-3),
        float(np.deg2rad(turn * placing.turn_deg)),
        float(np.deg2rad(plan.direction_deg)),
        plan.kind == "rotation",
    )
    return Placed(unit, body(plan.object_name), (float(tilt[0]), float(tilt[1])), path)


def _window(script: Script) -> tuple[int, int]:
    """[first, last) sample in which the skin is integrated: the motion and its ring-down; one sample where none is."""
    if script.moving is None:
        return 0, 1
    first, last = script.moving
    return first, min(last + round(_RING_DOWN_S * FORCE_RATE_HZ), len(script.travel))


def _travel_over_skin(path: Path, script: Script, shift: Array) -> Array:
    """Travel (t,) of the pattern over the taxels: the object's, less what the skin is dragged along."""
    if path.turns:
        return script.travel
    return script.travel - shift @ np.array([np.cos(path.direction), np.sin(path.direction)])


@dataclass(frozen=True)
class _History:
    """What a trial keeps of its drag, the cells summed up.

    skin_shift (t, 2; m), shear_force (t, 2; N), slip (t,; m), slip_share and stick_ratio (t,), and taxel_change
    (t, 16; N), the change of the taxel loads by exchange between crowns and by shear.
    """

    skin_shift: Array
    shear_force: Array
    slip: Array
    slip_share: Array
    stick_ratio: Array
    taxel_change: Array


def _history(
    scene: SlipScene, unit: FVSightUnit, path: Path, track: Track, pieces: Iterable[Drag], travel: Array
) -> _History:
    felt = scene.effects.crowns or scene.effects.shear_moment
    footprint = Footprint.of(unit.skin.film, unit.grid.size_m, CELL_M) if felt else None
    kept, first = [], 0
    for piece in pieces:
        along = travel[first : first + len(piece.slip)]
        first += len(along)
        change = np.zeros((len(along), 16))
        if footprint is not None:
            place = path.to_sensor(track.cells.place, along) - piece.skin_shift[:, None]
            shear = piece.shear if scene.effects.shear_moment else 0 * piece.shear
            change = footprint.taxel_change(place, piece.exchanged, shear)
        pull = piece.shear.sum(axis=1)
        kept.append((piece.skin_shift, pull, piece.slip, piece.slip_share, piece.stick_ratio, change))
    return _History(*(np.concatenate(parts) for parts in zip(*kept, strict=True)))


def _truth(
    names: tuple[str, ...], taxels: Array, history: _History, at: NDArray[np.intp], path: Path, script: Script
) -> Mapping[str, NDArray[Any]]:
    def field(name: str) -> NDArray[Any]:
        if name == "pose":
            return np.stack(path.pose(script.travel), axis=-1)
        if name == "taxel_load":
            return taxels.astype(np.float32)
        if name == "shear_force":
            return history.shear_force[at].astype(np.float32)
        values = {
            "slip_distance": history.slip,
            "slip_share": history.slip_share,
            "stick_ratio": history.stick_ratio,
            "skin_shift": history.skin_shift,
        }
        return values[name][at].astype(np.float32)

    return {name: field(name) for name in names}
