"""Slip scenes: the protocol's layout, the committed file, refusals that say what is wrong."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from sensors.slide import KINDS, SlipScene

CONFIGS = Path(__file__).parents[3] / "configs"


def merged(base, over):
    out = dict(base)
    for key, value in over.items():
        out[key] = merged(out[key], value) if isinstance(value, dict) and isinstance(out.get(key), dict) else value
    return out


def committed(variation):
    data = yaml.safe_load(next(CONFIGS.rglob("fvsight-slip.yaml")).read_text())
    return SlipScene(**merged(data, data.pop("variations")[variation]))


def test_the_paper_shows_three_objects_twenty_times():
    scene = committed("paper")
    plans = [scene.plan(index) for index in range(scene.n_samples)]
    assert scene.n_samples == 60
    for name in ("ball", "cuboid", "cylinder"):
        mine = [plan for plan in plans if plan.object_name == name]
        assert [plan.trial for plan in mine] == list(range(20))
        assert {(plan.kind, plan.load_n, plan.speed_mm_s, plan.unit) for plan in mine} == {("slide", 5.0, 10.0, 0)}


def test_the_hard_scene_shows_every_kind_with_every_object_and_unit():
    scene = committed("hard")
    plans = [scene.plan(index) for index in range(scene.n_samples)]
    assert len(plans) == 3 * len(KINDS) * 20
    assert {(plan.object_name, plan.kind, plan.unit) for plan in plans} == {
        (name, kind, unit) for name in scene.object_names for kind in KINDS for unit in range(3)
    }
    slides = [plan for plan in plans if plan.kind == "slide" and plan.object_name == "ball"]
    assert len({(plan.speed_mm_s, plan.load_n) for plan in slides}) == 15
    assert all(plan.speed_mm_s == 0 for plan in plans if plan.kind in ("drift", "rotation"))
    assert all((plan.rotation_deg_s != 0) == (plan.kind == "rotation") for plan in plans)


def test_the_negatives_last_three_hundred_minutes():
    scene = committed("negatives")
    assert scene.n_samples * scene.motion.negative_s / 60 >= 300
    assert not {"slide", "rotation"} & set(scene.protocol.kinds)


def test_the_scene_without_variation_is_valid():
    assert not committed("no-variation").effects.crowns


def test_the_pad_on_a_plate_slips_cell_by_cell():
    scene = committed("gel-pad")
    assert scene.sensor.support == "plate"
    assert scene.effects.partial_slip
    assert not committed("paper").effects.partial_slip


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"objects": ["bal"]}, "expected one of ball"),
        ({"protocol": {"kinds": ["slide", "slide"]}}, "once"),
        ({"protocol": {"kinds": ["slid"]}}, "slide"),
        ({"conditions": {"speeds_mm_s": [0.0]}}, "speeds_mm_s"),
        ({"conditions": {"rotations_deg_s": [0.0]}}, "rotations_deg_s"),
        ({"friction": {"dynamic": 0.9}}, "must not exceed static"),
        ({"friction": {"partial_share": 0.95}}, "below gross_share"),
        ({"motion": {"rest_jitter_s": 0.9}}, "does not fit"),
        ({"disturbances": {"tap_s": [0.1, 0.05]}}, "tap_s"),
        ({"effects": {"partial_slip": True}}, "bonded to a plate"),
        (
            {"effects": {"partial_slip": True}, "sensor": {"support": "plate"}, "protocol": {"kinds": ["rotation"]}},
            "rotation",
        ),
        ({"colour": "red"}, "colour"),
        ({"conditions": {"speeds_mm_s": [np.nan]}}, "speeds_mm_s.0\n.*finite"),
        ({"conditions": {"directions_deg": [np.inf]}}, "directions_deg.0\n.*finite"),
        ({"friction": {"areal_mass_kg_m2": 1e-9}}, "areal_mass_kg_m2"),
        ({"motion": {"move_s": 1e-6}}, "move_s"),
        ({"disturbances": {"drift_gain": 3.0}}, "drift_gain"),
    ],
    ids=str,
)
def test_impossible_scenes_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        SlipScene(id="bad", title="bad", **change)


def test_negative_indices_are_refused():
    with pytest.raises(ValueError, match=">= 0"):
        committed("paper").plan(-1)
