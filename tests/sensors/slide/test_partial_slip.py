"""A film on a plate that shears cell by cell: Coulomb's limit, rim first, memory of reversals, threads that follow."""

import numpy as np
import pytest

from sensors.fvsight import fvsight_unit
from sensors.slide import GROSS, PARTIAL, SLIDE_TRUTH, STICK, SlipScene, simulate_slide
from sensors.slide.membrane import field_modes
from sensors.slide.partial_slip import Sheared, solved_samples
from sensors.slide.scene import SlideEffects
from sensors.slide.sensing import sheared_weave
from sensors.slide.simulate import place_body

FILM_M, LOAD_N, MU = 4e-3, 5.0, 0.5
QUIET = dict.fromkeys(("unit_spread", "session_drift", "force_noise", "camera_noise", "crowns", "late_film"), False)
SHORT = {"rest_s": 0.1, "rest_jitter_s": 0.0, "move_s": 0.3, "settle_s": 0.2, "longest_mm": 2.5}


def scene_with(kind="slide", **changes):
    pad = {"support": "plate", "grid": 64, "film_thickness_mm": 1e3 * FILM_M, "film_modulus_mpa": 0.3}
    base = {
        "objects": ["ball"],
        "sensor": pad | changes.pop("sensor", {}),
        "protocol": {"kinds": [kind]},
        "placing": {"offset_mm": 0.0, "turn_deg": 0.0, "tilt_deg": 0.0},
        "conditions": {"load_spread": 0.0} | changes.pop("conditions", {}),
        "motion": SHORT | {"load_ripple": 0.0, "moving_noise": 0.0},
        "friction": {"spread": 0.0, "dynamic": MU} | changes.pop("friction", {}),
        "effects": QUIET | {"partial_slip": True} | changes.pop("effects", {}),
    }
    return SlipScene(id="t", title="t", **base)


@pytest.fixture(scope="module")
def slide():
    return simulate_slide(scene_with(), 0, 0, SLIDE_TRUTH, frames=True)


def test_the_contact_lets_go_from_stick_through_partial_to_gross_slip(slide):
    ratio, onset = slide.truth["stick_ratio"], slide.onset_sample
    assert (ratio[:100] == 1).all()
    assert np.diff(ratio[:onset]).max() < 1e-6
    assert len(np.unique(ratio[100:onset].round(3))) > 15
    assert (ratio[onset + 20 : 330] == 0).all()
    assert [slide.state[at] for at in (50, onset - 20, onset + 20, -1)] == [STICK, PARTIAL, GROSS, STICK]
    # slip starts at the rim, where little load lies
    partial = slice(110, onset)
    assert (slide.truth["slip_share"][partial] <= 1 - ratio[partial] + 1e-6).all()


def test_friction_carries_its_limit_and_never_more(slide):
    pull = np.hypot(*slide.truth["shear_force"].T)
    assert pull.max() <= MU * LOAD_N * (1 + 1e-4)
    assert pull[slide.onset_sample + 50 : 330] == pytest.approx(MU * LOAD_N, rel=1e-3)
    assert np.diff(pull[100 : slide.onset_sample]).min() > -1e-6
    assert slide.truth["taxel_load"].sum(axis=1) == pytest.approx(LOAD_N, rel=0.01)


def test_a_thick_film_sticks_on_the_area_of_cattaneo_and_mindlin():
    """A ball on nearly a half-space, stiff threads: (1 - Q / mu P)^(2/3), to 2.5 % of the contact (18 cells across)."""
    thick = {"film_thickness_mm": 30.0, "grid": 128}
    scene = scene_with(sensor=thick, friction={"weave_mpa_per_mm": 1e4, "slip_speed_mm_s": 1e-3})
    truth = simulate_slide(scene, 0, 0, ("shear_force", "stick_ratio")).truth
    share = truth["shear_force"][:, 0] / (MU * LOAD_N)
    for wanted in (0.2, 0.4, 0.6, 0.8, 0.95):
        at = int(np.argmax(share >= wanted))
        assert truth["stick_ratio"][at] == pytest.approx((1 - share[at]) ** (2 / 3), abs=0.025)


def test_a_contact_that_does_not_slip_is_a_spring():
    grippy = scene_with(friction={"static": 2.0, "dynamic": 2.0})
    truth = simulate_slide(grippy, 0, 0, SLIDE_TRUTH).truth
    travel, pull = truth["pose"][:, 0] - truth["pose"][0, 0], truth["shear_force"][:, 0]
    some, twice = (int(np.searchsorted(travel, part)) for part in (0.1e-3, 0.2e-3))
    assert pull[twice] / pull[some] == pytest.approx(travel[twice] / travel[some], rel=0.02)
    assert 0.8 * travel[twice] < truth["skin_shift"][twice, 0] < travel[twice]
    assert truth["slip_distance"][twice] < 0.04 * travel[twice]


def test_what_slipped_on_the_way_forth_pulls_back_on_the_return():
    truth = simulate_slide(scene_with("incipient"), 0, 0, SLIDE_TRUTH).truth
    pull = truth["shear_force"][:, 0]
    assert truth["pose"][-1, 0] == pytest.approx(truth["pose"][0, 0], abs=1e-9)
    assert -0.5 * pull.max() < pull[-1] < -0.001 * pull.max()
    assert 0 < truth["stick_ratio"].min() < 1


def test_the_direction_of_the_drag_does_not_matter_on_a_ball(slide):
    across = simulate_slide(scene_with(conditions={"directions_deg": [90.0]}), 0, 0, SLIDE_TRUTH).truth
    for name in ("shear_force", "skin_shift"):
        assert across[name][:, ::-1] == pytest.approx(
            slide.truth[name], rel=0.01, abs=0.01 * float(slide.truth[name].max())
        )


def test_the_taxels_stay_where_they_are_under_the_load_that_moves_on():
    """Without the moment of the shear they read the contact at the object's own place."""
    scene = scene_with(effects={"shear_moment": False})
    truth = simulate_slide(scene, 0, 0, SLIDE_TRUTH).truth
    unit = fvsight_unit(scene.effective_sensor(), 0)
    placed = place_body(scene, scene.plan(0), unit, np.random.default_rng([0, 0]).spawn(5)[0])
    there = unit.taxel_load(placed.solve(float(truth["pose"][-1, 0] - truth["pose"][0, 0]), LOAD_N).pressure)
    assert truth["taxel_load"][-1] == pytest.approx(there, abs=0.01 * LOAD_N)


def test_the_camera_sees_other_threads_move_than_those_of_one_patch(slide):
    patch = simulate_slide(scene_with(effects={"partial_slip": False}), 0, 0, frames=True)
    assert np.array_equal(patch.frames[0], slide.frames[0])
    at = int(np.argmin(np.abs(slide.frame_time_s - slide.onset_sample / slide.rate_hz)))
    change = np.abs(slide.frames[at].astype(float) - patch.frames[at]).max(axis=-1)
    rows, columns = np.nonzero(change > 5)
    assert len(rows) > 50
    assert max(np.abs(rows - 128).max(), np.abs(columns - 128).max()) < 40
    assert patch.onset_sample < slide.onset_sample


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, 0.8)])
def test_a_face_that_moves_as_one_drags_its_threads_as_one(direction):
    unit = fvsight_unit(scene_with().effective_sensor(), 0)
    bump = np.outer(*[np.hanning(unit.grid.n)] * 2)
    whole = np.stack([5e-4 * part * bump for part in direction])
    face = np.stack([0 * whole, whole]).astype(np.float32)
    none = np.zeros(2)
    sheared = Sheared(np.arange(3.0), np.array([0.0, 2.0]), np.ones(3, bool), face, none, none, none, none, none)
    weave = sheared_weave(unit, sheared, np.arange(3))
    shape = unit.camera.shift_shape(field_modes(bump))
    half = tuple(2.5e-4 * part for part in direction)
    assert weave(1) == pytest.approx(unit.camera.dragged_weave(shape, half), abs=1e-3)
    assert np.abs(weave(1) - 1).max() > 0.1
    assert weave(0) == pytest.approx(np.ones_like(shape), abs=1e-3)


def test_samples_are_solved_on_both_sides_of_every_rest_and_turn():
    forth = np.linspace(0, 1e-3, 101)
    travel = np.concatenate([forth, np.full(50, 1e-3), forth[::-1][1:]])
    chosen = solved_samples(travel, 1e-4, 3e-4, 5e-4)
    assert {0, 100, 101, 150, 151, len(travel) - 1} <= set(chosen)
    near = [at for at in chosen if 0 < travel[at] <= 3e-4 and at < 100]
    assert np.diff(travel[near]) == pytest.approx(1e-4, abs=1.1e-5)
    assert len(solved_samples(travel, 1e-9, 1.0, 1.0)) > 3 * len(chosen)
    assert list(solved_samples(np.zeros(1), 1e-4, 3e-4, 5e-4)) == [0]


def test_the_effect_is_off_and_unnamed_unless_it_is_asked_for():
    assert not SlideEffects().partial_slip
    assert "partial_slip" not in SlipScene(id="t", title="t").model_dump()["effects"]
    scene = scene_with()
    assert scene.model_dump()["effects"]["partial_slip"]
    assert SlipScene(**scene.model_dump(mode="json")) == scene


@pytest.mark.parametrize("kind", ["load_change", "tapping", "drift", "recovery"])
def test_trials_without_motion_run_and_only_stick(kind):
    scene = scene_with(kind)
    recording = simulate_slide(scene, 0, 0, ("stick_ratio", "shear_force"))
    assert (recording.truth["stick_ratio"] == 1).all()
    assert not recording.truth["shear_force"].any()
    assert recording.onset_sample is None
