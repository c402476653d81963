"""Press scenes: layout of the protocol, determinism, effects that are off, history against direct solves."""

import numpy as np
import pytest

from sensors import simulate
from sensors.fvsight import fvsight_unit
from sensors.press import load_history, presented_gap, taxel_history
from sensors.scene import PressScene, nominal_pose, plan

SCENE = PressScene(id="test", title="test", pose={"nominal_offset_mm": 8.0, "nominal_turn_deg": 180.0})
STILL = SCENE.model_copy(
    update={
        "load": SCENE.load.model_copy(update={"spread": 0.0}),
        "pose": SCENE.pose.model_copy(update={"reseat_mm": 0.0, "reseat_deg": 0.0}),
        "motion": SCENE.motion.model_copy(update={"ripple": 0.0}),
        "effects": SCENE.effects.model_copy(
            update=dict.fromkeys(("unit_spread", "session_drift", "force_noise", "camera_noise"), False)
        ),
    }
)


def test_layout_of_the_protocol():
    layout = [plan(SCENE, index) for index in range(SCENE.n_samples)]
    assert SCENE.n_samples == 27 * 12 * 6
    assert all(item.label == index % 27 for index, item in enumerate(layout))
    per_unit = layout[: 27 * 12]
    assert {item.unit for item in per_unit} == {0}
    for label in range(27):
        presses = [item.press for item in per_unit if item.label == label]
        assert (presses.count("deep"), presses.count("shallow")) == (10, 2)
    for session in range(4):
        assert {item.label for item in per_unit if item.session == session} == set(range(27))


def test_nominal_poses_are_drawn_once():
    poses = {nominal_pose(SCENE.pose, label) for label in range(27)}
    assert len(poses) == 27
    assert nominal_pose(SCENE.pose, 5) == nominal_pose(SCENE.pose, 5)
    assert all(abs(x) <= 8 and abs(y) <= 8 and abs(turn) <= 180 for x, y, turn in poses)


def test_a_sample_depends_on_scene_index_and_seed_alone():
    first, again, other = simulate(SCENE, 40, 7), simulate(SCENE, 40, 7), simulate(SCENE, 40, 8)
    assert np.array_equal(first.image, again.image)
    assert np.array_equal(first.force_series, again.force_series)
    assert not np.array_equal(first.image, other.image)


def test_a_recording_is_consistent_with_itself():
    recording = simulate(SCENE, 3, 0, truth=("displacement", "pressure", "contact"))
    start, stop = recording.hold
    assert recording.force == pytest.approx(recording.force_series[start:stop].mean(axis=0), abs=1e-5)
    assert recording.taxel_load.sum() == pytest.approx(recording.total_force_n, rel=0.01)
    assert start / recording.rate_hz < recording.image_time_s < stop / recording.rate_hz
    assert recording.force_series[0] == pytest.approx(0, abs=0.15)
    assert np.array_equal(recording.truth["contact"], recording.truth["pressure"] > 0)
    area = (0.08 / 128) ** 2
    assert recording.truth["pressure"].sum() * area == pytest.approx(recording.total_force_n, rel=1e-4)
    assert len(recording.force_time_s) == len(recording.force_series)


def test_with_all_variation_off_rounds_repeat_exactly():
    first, next_round, next_unit = (simulate(STILL, index, 0) for index in (2, 29, 326))
    assert np.array_equal(first.image, next_round.image)
    assert np.array_equal(first.force, next_round.force)
    assert np.array_equal(first.image, next_unit.image)


def test_rest_frames_show_no_object():
    frames = [simulate(STILL, index, 0).image_rest for index in (0, 1)]
    assert np.array_equal(*frames)


def test_switching_one_effect_off_leaves_the_others_alone():
    quiet = SCENE.model_copy(update={"effects": SCENE.effects.model_copy(update={"force_noise": False})})
    loud, silent = simulate(SCENE, 11, 0), simulate(quiet, 11, 0)
    assert np.array_equal(loud.image, silent.image)
    assert not np.array_equal(loud.force_series, silent.force_series)


def test_shallow_presses_are_lighter_and_shallower():
    deep, shallow = simulate(SCENE, 0, 0), simulate(SCENE, 27 * 5, 0)
    assert (deep.labels["press"], shallow.labels["press"]) == ("deep", "shallow")
    assert shallow.total_force_n < 0.5 * deep.total_force_n
    assert shallow.indentation_mm < deep.indentation_mm


@pytest.mark.parametrize("label", [0, 6, 21])
def test_history_agrees_with_a_solve_at_a_load_between_its_levels(label):
    unit = fvsight_unit(SCENE.effective_sensor(), 0)
    pose = nominal_pose(SCENE.pose, label)
    gap = presented_gap(SCENE.object_names[label], unit, pose, 0.056)
    press = unit.press(gap, 5.0)
    load = np.array([0.0, 1.7, 3.6, 5.0])
    history = taxel_history(unit, gap, press, load)
    assert history.sum(axis=1) == pytest.approx(load, rel=0.01, abs=1e-9)
    for moment in (1, 2):
        direct = unit.press(gap, load[moment]).taxel_load
        assert history[moment] == pytest.approx(direct, abs=0.05 * load[moment])


def test_load_history_rises_holds_and_falls():
    load, (start, stop) = load_history(STILL.motion, 4.0, np.random.default_rng(0))
    assert (np.diff(load[:start]) > 0).all()
    assert load[start:stop] == pytest.approx(4.0)
    assert (np.diff(load[stop:]) < 0).all()
    assert load[-1] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"pose": {"jitter_mm": 19.0}}, "reaches the rim"),
        ({"objects": ["spoon", "spon"]}, "spoon"),
        ({"protocol": {"shallow_rounds": [12]}}, "shallow_rounds"),
        ({"load": {"deep_n": -1.0}}, "deep_n"),
        ({"colour": "red"}, "colour"),
        ({"sensor": {"film_thickness_mm": np.inf}}, "film_thickness_mm"),
        ({"motion": {"approach_s": 1e-6}}, "approach_s"),
        ({"motion": {"hold_s": 1e-6}}, "hold_s"),
        ({"motion": {"release_s": 1e-6}}, "release_s"),
        ({"pose": {"reseat_mm": np.nan}}, "reseat_mm"),
    ],
)
def test_impossible_scenes_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        PressScene(id="bad", title="bad", **change)


def test_unknown_truth_is_refused():
    with pytest.raises(ValueError, match="displacment"):
        simulate(SCENE, 0, 0, truth=("displacment",))
