"""What the arm does: profiles that keep speed, distance and acceleration; each kind does what it is called."""

import numpy as np
import pytest

from sensors.slide.scene import KINDS, SlipScene
from sensors.slide.script import travel_profile, write_script

SCENE = SlipScene(id="t", title="t", protocol={"kinds": KINDS})
STILL = SCENE.model_copy(update={"motion": SCENE.motion.model_copy(update={"load_ripple": 0.0, "moving_noise": 0.0})})


def script(kind, seed=0, scene=STILL):
    plan = scene.plan(3 * KINDS.index(kind))
    assert plan.kind == kind
    return write_script(scene, plan, 5.0, 4e-4, np.random.default_rng(seed))


@pytest.mark.parametrize(("distance", "speed"), [(12e-3, 10e-3), (2e-4, 10e-3), (12e-3, 40e-3)])
def test_a_profile_keeps_distance_speed_and_acceleration(distance, speed):
    way = travel_profile(distance, speed, 0.5)
    rate = np.diff(way) * 1000
    assert way[0] == 0
    assert way[-1] == pytest.approx(distance, rel=1e-9)
    assert (rate >= -1e-12).all()
    assert rate.max() <= speed * (1 + 1e-9)
    assert np.abs(np.diff(rate)).max() * 1000 <= 0.5 * (1 + 1e-6)


def test_a_slide_rests_moves_and_rests():
    written = script("slide")
    first, last = written.moving
    assert len(written.travel) == 3000
    assert 790 < first < 1210
    assert (written.travel[: first + 1] == 0).all()
    assert written.travel[last:] == pytest.approx(12e-3)
    assert written.load == pytest.approx(5.0)
    assert (first, last) != script("slide", seed=1).moving


def test_a_fast_slide_ends_after_the_longest_distance():
    fast = STILL.model_copy(update={"conditions": STILL.conditions.model_copy(update={"speeds_mm_s": (40.0,)})})
    assert script("slide", scene=fast).travel.max() == pytest.approx(12e-3)


def test_a_rotation_turns_by_rate_times_time():
    assert script("rotation").travel[-1] == pytest.approx(np.deg2rad(60 * 1.2))


def test_incipient_motion_stays_short_of_slip_and_comes_back():
    for seed in range(5):
        travel = script("incipient", seed).travel
        assert 0.3 * 4e-4 <= travel.max() <= 0.6 * 4e-4
        assert travel[-1] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("kind", ["load_change", "tapping", "drift", "recovery"])
@pytest.mark.parametrize("seed", range(3))
def test_negatives_without_lateral_motion_have_none(kind, seed):
    written = script(kind, seed)
    assert written.moving is None
    assert len(written.load) == 3000
    assert (written.load >= 0).all()
    assert written.load.max() <= 1.1 * 5 * (1 + 1e-9)


def test_each_negative_does_what_it_is_called():
    assert np.ptp(script("load_change").load) > 0.5
    tapping = script("tapping").load
    assert (tapping == 0).mean() > 0.5
    assert (np.diff((tapping > 0).astype(int)) == 1).sum() >= 4
    drift = script("drift")
    assert np.abs(np.diff(drift.load)).max() * 1000 < 5.0
    assert drift.gain.shape == (3000, 16)
    assert (drift.gain[0] == 1).all()
    recovery = script("recovery").load
    assert recovery[0] == 5.0
    assert recovery.min() <= 0.2 * 5
    vibration = script("arm_vibration")
    assert 0 < np.abs(vibration.travel).max() <= 20e-6
    assert 0 < np.abs(vibration.load - 5).max() <= 0.05 * 5
    assert np.abs(vibration.travel[:400]).max() == 0


def test_the_arm_ripples_and_its_force_control_is_worse_in_motion():
    written = script("slide", scene=SCENE)
    first, last = written.moving
    ripple = written.load[:first] / 5 - 1
    assert np.abs(ripple).max() == pytest.approx(0.004, rel=0.01)
    assert written.load[first + 100 : last - 100].std() > 1.3 * written.load[:first].std()


def test_long_negatives_keep_doing_it():
    long = STILL.model_copy(update={"motion": STILL.motion.model_copy(update={"negative_s": 20.0})})
    for kind in ("load_change", "tapping", "recovery", "arm_vibration"):
        written = script(kind, scene=long)
        assert len(written.load) == 20000
        assert np.ptp(written.load[-6000:]) > 0
