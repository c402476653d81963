"""Trials of slip scenes: stick before, Coulomb after, an onset that belongs to the friction and not to the script."""

import numpy as np
import pytest

from sensors.fvsight import fvsight_unit
from sensors.slide import GROSS, KINDS, PARTIAL, SLIDE_TRUTH, SLIPPING, STICK, SlipScene, simulate_slide
from sensors.slide.drag import BLOCK, drag, presliding_distance, skin_patch
from sensors.slide.membrane import in_plane_skin
from sensors.slide.path import Path
from sensors.slide.shapes import body
from sensors.slide.track import Placed, lay_track, traction_modes

SHORT = {"rest_s": 0.3, "rest_jitter_s": 0.0, "move_s": 0.4, "settle_s": 0.3, "longest_mm": 3.0, "negative_s": 2.0}
QUIET = dict.fromkeys(("unit_spread", "session_drift", "force_noise", "camera_noise", "crowns", "late_film"), False)


def scene_with(**changes):
    base = {
        "conditions": {"load_spread": 0.0, **changes.pop("conditions", {})},
        "motion": SHORT | {"load_ripple": 0.0, "moving_noise": 0.0},
        "friction": {"spread": 0.0, **changes.pop("friction", {})},
        "effects": QUIET | changes.pop("effects", {}),
    }
    return SlipScene(id="t", title="t", **(base | changes))


SMOOTH = scene_with()
FULL = SlipScene(id="t", title="t", protocol={"kinds": KINDS}, motion=SHORT)


@pytest.fixture(scope="module")
def smooth():
    return [simulate_slide(SMOOTH, index, 0, truth=SLIDE_TRUTH) for index in range(3)]


@pytest.mark.parametrize("kind", ["arm_vibration", "rotation"])
def test_a_long_trial_is_integrated_in_blocks_that_leave_no_trace(monkeypatch, kind):
    """What each cell carries is held for one block at a time; the trial does not tell where one ended."""
    lengths = []

    def in_blocks(*arguments):
        for piece in drag(*arguments, block=97):
            lengths.append(len(piece.shear))
            yield piece

    index = next(index for index in range(len(KINDS) * 3) if FULL.plan(index).kind == kind)
    whole = simulate_slide(FULL, index, 0, truth=SLIDE_TRUTH)
    monkeypatch.setattr("sensors.slide.simulate.drag", in_blocks)
    blocked = simulate_slide(FULL, index, 0, truth=SLIDE_TRUTH)
    assert len(lengths) > 3
    assert max(lengths) == 97 < BLOCK
    np.testing.assert_array_equal(whole.force_series, blocked.force_series)
    np.testing.assert_array_equal(whole.state, blocked.state)
    for name in SLIDE_TRUTH:
        np.testing.assert_array_equal(whole.truth[name], blocked.truth[name], err_msg=name)


def test_nothing_moves_before_the_motion_and_after_it_has_rung_down(smooth):
    for recording in smooth:
        assert np.ptp(recording.truth["taxel_load"][:300], axis=0).max() == 0
        assert (recording.state[:300] == STICK).all()
        assert np.ptp(recording.force_series[-50:], axis=0).max() == 0
        assert (recording.state[-50:] == STICK).all()


def test_partial_slip_comes_before_gross_slip_and_both_after_the_motion_starts(smooth):
    for recording in smooth:
        partial = int(np.flatnonzero(recording.state == PARTIAL)[0])
        assert 300 < partial < recording.onset_sample < 600
        assert recording.onset_sample == np.flatnonzero(recording.state == GROSS)[0]
        share = recording.truth["slip_share"]
        assert share[recording.onset_sample - 1] < 0.9 <= share[recording.onset_sample]


def test_sliding_costs_the_dynamic_friction_of_the_load(smooth):
    for recording in smooth:
        drag = recording.truth["shear_force"][recording.onset_sample + 150]
        # at 10 mm/s, twice the Stribeck speed, a fiftieth of the rise to static friction is left
        assert drag == pytest.approx([(0.5 + 0.1 * np.exp(-4)) * 5.0, 0], rel=0.01, abs=0.01)
        assert recording.truth["taxel_load"].sum(axis=1) == pytest.approx(5.0, rel=0.01)


def test_the_object_slides_by_its_travel_less_the_strain(smooth):
    for recording in smooth:
        travel = np.hypot(*np.diff(recording.truth["pose"][[0, -1], :2], axis=0)[0])
        assert travel == pytest.approx(3e-3)
        assert 0.3e-3 < travel - recording.truth["slip_distance"][-1] < 1e-3


@pytest.mark.parametrize(
    ("change", "later"),
    [
        ({"friction": {"static": 1.2, "dynamic": 1.0}}, True),
        ({"friction": {"static": 0.3, "dynamic": 0.25}}, False),
        ({"friction": {"weave_mpa_per_mm": 0.05}}, True),
        ({"conditions": {"loads_n": [2.0]}}, False),
        ({"conditions": {"speeds_mm_s": [5.0]}}, True),
    ],
)
def test_the_onset_comes_from_the_friction(smooth, change, later):
    changed = simulate_slide(scene_with(**change), 0, 0)
    assert (changed.onset_sample > smooth[0].onset_sample) == later
    assert changed.onset_sample != smooth[0].onset_sample


def test_the_frame_of_reference_may_be_turned(smooth):
    # a square sensor, a ball: a slide along y reads as the slide along x with rows and columns swapped
    sideways = scene_with(conditions={"directions_deg": [90.0]}, placing={"offset_mm": 0.0, "tilt_deg": 0.0})
    along = scene_with(placing={"offset_mm": 0.0, "tilt_deg": 0.0})
    first, second = (simulate_slide(scene, 0, 0, truth=("taxel_load",)) for scene in (along, sideways))
    swapped = second.truth["taxel_load"].reshape(-1, 4, 4).swapaxes(1, 2).reshape(-1, 16)
    assert np.abs(swapped - first.truth["taxel_load"]).max() < 0.02
    assert abs(first.onset_sample - second.onset_sample) <= 1


def test_the_skin_is_dragged_and_tips_its_load_ahead(smooth):
    without = simulate_slide(scene_with(effects={"shear_moment": False}), 0, 0, truth=("taxel_load",))
    recording = smooth[0]
    at = recording.onset_sample
    ahead = recording.truth["taxel_load"].reshape(-1, 4, 4)[:, :, 2:].sum(axis=(1, 2))
    without_ahead = without.truth["taxel_load"].reshape(-1, 4, 4)[:, :, 2:].sum(axis=(1, 2))
    assert ahead[at] - without_ahead[at] > 0.05
    assert ahead[:300] == pytest.approx(without_ahead[:300])
    assert 1e-4 < recording.truth["skin_shift"][at, 0] < 4e-4


def test_crowns_speak_only_while_there_is_slip(smooth):
    crowned = simulate_slide(scene_with(effects={"crowns": True}), 1, 0, truth=("taxel_load",))
    change = np.diff(crowned.truth["taxel_load"] - smooth[1].truth["taxel_load"], axis=0)
    assert (change[:300] == 0).all()
    sliding = slice(smooth[1].onset_sample + 20, 650)
    assert change[sliding].std() > 2e-4
    assert crowned.truth["taxel_load"].sum(axis=1) == pytest.approx(5.0, rel=0.01)


@pytest.mark.parametrize("kind", KINDS)
def test_kinds_slip_or_do_not(kind):
    index = 3 * KINDS.index(kind) + 1
    recording = simulate_slide(FULL, index, 0, truth=("slip_share",))
    assert recording.labels["kind"] == kind
    assert (recording.onset_sample is not None) == (kind in SLIPPING)
    assert ((recording.state == GROSS).any()) == (kind in SLIPPING)
    if kind in ("load_change", "tapping", "drift", "recovery"):
        assert (recording.state == STICK).all()
    assert np.isfinite(recording.force_series).all()
    assert recording.force_series.dtype == np.float32
    assert recording.force_series.shape == (len(recording.state), 16)
    assert len(recording.force_time_s) == len(recording.state)


def test_an_incipient_slip_is_partial_at_most():
    scene = scene_with(
        protocol={"kinds": ["incipient"]}, disturbances={"incipient_shares": [0.6, 0.6]}, motion=SHORT | {"move_s": 0.9}
    )
    partial = [np.any(simulate_slide(scene, index, 0).state == PARTIAL) for index in range(3)]
    gross = [np.any(simulate_slide(scene, index, 0).state == GROSS) for index in range(3)]
    assert any(partial)
    assert not any(gross)


def test_the_presliding_distance_is_what_a_slow_slide_needs():
    slow = scene_with(conditions={"speeds_mm_s": [2.0]}, friction={"static": 0.5}, motion=SHORT | {"load_ripple": 0.0})
    plan = slow.plan(1)
    unit = fvsight_unit(slow.effective_sensor(), plan.unit)
    recording = simulate_slide(slow, 1, 0, truth=("pose",))
    pose = recording.truth["pose"]
    travelled = np.hypot(*(pose[recording.onset_sample] - pose[0])[:2])
    there = Placed(unit, body("cuboid"), (0.0, 0.0), Path(*pose[0], 0.0, False))
    start = there.solve(0.0, 5.0)
    skin = in_plane_skin(unit.grid, unit.skin.film, slow.friction.areal_mass_kg_m2, traction_modes(unit, start))
    track = lay_track(there, np.zeros(1), np.full(1, 5.0), start)
    patch = skin_patch(slow.friction, unit.skin.film, skin, track.cells, 1.0)
    assert travelled == pytest.approx(presliding_distance(patch, track.cell_share[0] * 5.0, 0.9), rel=0.2)


def test_after_a_release_the_film_recovers_late():
    late = scene_with(protocol={"kinds": ["recovery"]}, effects={"late_film": True, "hysteresis": False})
    prompt = scene_with(protocol={"kinds": ["recovery"]}, effects={"hysteresis": False})
    with_film, without = (simulate_slide(scene, 0, 0) for scene in (late, prompt))
    held = with_film.force_series[:500] - without.force_series[:500]
    assert held == pytest.approx(0, abs=1e-3)
    excess = (with_film.force_series - without.force_series).sum(axis=1)
    top = int(excess.argmax())
    assert 0.05 * 5 * 0.5 < excess[top] < 0.05 * 5
    # 0.35 s later a factor e less
    assert excess[top + 350] == pytest.approx(excess[top] / np.e, rel=0.1)


@pytest.mark.parametrize("kind", ["slide", "rotation", "arm_vibration"])
def test_a_trial_depends_on_scene_index_and_seed_alone(kind):
    index = 3 * KINDS.index(kind)
    first, again, other = (simulate_slide(FULL, index, seed) for seed in (5, 5, 6))
    assert np.array_equal(first.force_series, again.force_series)
    assert np.array_equal(first.state, again.state)
    assert first.labels == again.labels
    assert not np.array_equal(first.force_series, other.force_series)


def test_truth_and_frames_leave_the_forces_alone():
    plain = simulate_slide(FULL, 0, 0)
    seen = simulate_slide(FULL, 0, 0, truth=SLIDE_TRUTH, frames=True)
    assert np.array_equal(plain.force_series, seen.force_series)
    assert plain.frames is None
    assert seen.frames.shape == (30, 256, 256, 3)
    assert seen.frame_time_s == pytest.approx(np.arange(30) / 30)
    assert seen.frame_time_s[-1] <= seen.force_time_s[-1]
    assert set(seen.truth) == set(SLIDE_TRUTH)
    assert all(len(values) == len(seen.state) for values in seen.truth.values())


def test_frames_rest_while_the_contact_rests_and_change_with_it():
    recording = simulate_slide(SMOOTH, 0, 0, frames=True)
    frames = recording.frames.astype(int)
    moving = (recording.frame_time_s > 0.3) & (recording.frame_time_s < 0.6)
    change = np.abs(np.diff(frames, axis=0)).mean(axis=(1, 2, 3))
    assert (change[recording.frame_time_s[1:] < 0.3] == 0).all()
    assert (change[moving[1:]] > 0).all()
    assert (change[recording.frame_time_s[:-1] > 0.9] == 0).all()


def test_unknown_truth_is_refused():
    with pytest.raises(ValueError, match="slip_distanc"):
        simulate_slide(SMOOTH, 0, 0, truth=("slip_distanc",))


def test_a_load_beyond_the_skin_is_refused():
    with pytest.raises(ValueError, match="lower the load"):
        simulate_slide(scene_with(conditions={"loads_n": [12.0]}), 0, 0)
