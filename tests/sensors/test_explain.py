"""What `explain` says: every effect's own size, measured by switching it."""

import re

import pytest

from sensors import explain
from sensors.explain_grids import press_grids, slide_warning
from sensors.explain_press import FLAGS, explain_press, n_effects, spread
from sensors.explain_slide import SLIDE_FLAGS, explain_slide, n_slide_effects
from sensors.fvsight import FVSightParameters
from sensors.grids.choose import measured_choices
from sensors.scene import Effects, PressScene
from sensors.slide import SlipScene
from sensors.slide.scene import SlideEffects, SlipMotion

SMALL = PressScene(id="small", title="small", objects=("button", "hex-nut"), sensor=FVSightParameters(grid=64))


@pytest.fixture(scope="module", autouse=True)
def _one_run_is_enough():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(explain, "REPEATS", 1)
        yield


@pytest.fixture(scope="module")
def full():
    ticks = []
    found = explain_press(SMALL, 1, advance=ticks.append)
    assert len(ticks) == len(found.effects) == n_effects(SMALL)
    return {row.name: row for row in found.effects}, found


def test_each_effect_moves_what_it_should_and_nothing_else(full):
    rows, _ = full
    assert rows["camera noise"].frame_levels > 0.3
    assert rows["camera noise"].force_n == 0
    assert rows["force noise"].force_n > 1e-3
    assert rows["force noise"].frame_levels == 0
    assert rows["hysteresis"].surface_um == 0
    assert rows["re-seating"].surface_um > 1
    assert rows["unit spread"].frame_levels > rows["camera noise"].frame_levels
    assert rows["bare sheet"].force_n > rows["creep and overshoot"].force_n > rows["hysteresis"].force_n > 0
    assert not rows["creep and overshoot"].on
    assert rows["weave moves along"].frame_levels > 0
    assert rows["shadows"].frame_levels == 0
    assert rows["stretching of the skin"].surface_um > 0


def test_a_scene_without_an_effect_shows_what_it_would_add(full):
    rows, _ = full
    bare = SMALL.model_copy(update={"effects": Effects(**dict.fromkeys(FLAGS, False))})
    found = {row.name: row for row in explain_press(bare, 1).effects}
    for name in FLAGS:
        shown = name.replace("_", " ")
        assert rows[shown].on
        assert not found[shown].on
    assert found["camera noise"].frame_levels == pytest.approx(rows["camera noise"].frame_levels, rel=0.2)


def test_a_sheet_that_creeps_shows_what_its_creep_does_and_without_it_none():
    """Switched on or off, the same two runs are compared."""
    shown = []
    for effects in (Effects(), Effects(creep=False)):
        sheet = SMALL.sensor.model_copy(update={"taxels": "velostat"})
        found = explain_press(SMALL.model_copy(update={"sensor": sheet, "effects": effects}), 1).effects
        shown.append(next(row for row in found if row.name == "creep and overshoot"))
    assert [row.on for row in shown] == [True, False]
    assert shown[0].force_n == pytest.approx(shown[1].force_n)
    assert shown[0].force_n > 0.05
    assert shown[0].frame_levels == shown[0].surface_um == 0


def test_the_grid_taken_is_among_those_measured(full):
    _, found = full
    assert [one.grid for one in found.grids if one.taken] == [64]
    taken = next(one for one in found.grids if one.taken)
    finest = max(found.grids, key=lambda one: one.grid)
    assert taken.error["frame"] > finest.error["frame"]
    assert "one contact model" in found.models
    assert found.stages_ms["frame total"] > found.stages_ms["contact"] > 0


def test_an_error_names_the_class_it_is_of_and_what_most_keep_to():
    """Both from one class at a time; the scene's own choice counts the worst of them."""
    scene = PressScene(id="all", title="all")
    taken = next(one for one in press_grids(scene) if one.taken)
    alone = {}
    for objects in scene.object_classes:
        choices = measured_choices(scene.sensor.model_dump(), (objects,), scene.loads_n)
        alone[objects] = next(one for one in choices if one.grid == scene.sensor.grid)
    for name, error in taken.error.items():
        assert getattr(alone[taken.worst[name]], name) == error == max(getattr(one, name) for one in alone.values())
        below = sum(getattr(one, name) <= taken.median[name] for one in alone.values())
        assert below == len(alone) // 2 + len(alone) % 2
    assert taken.worst["displacement"] == "cutlery"
    assert taken.median["displacement"] < 0.1 * taken.error["displacement"]


def test_a_slide_on_a_film_is_warned_of_points_and_a_slide_on_the_skin_is_not():
    film = {"support": "plate", "film_thickness_mm": 4.0, "film_modulus_mpa": 0.3}
    assert slide_warning(SlipScene(id="s", title="s")) == ""
    known = slide_warning(SlipScene(id="s", title="s", sensor=film))
    assert re.search(r"at 128x128 .* off by up to \d+% \(\w+; half of the classes up to \d+%\)", known)
    for other in ({"film_thickness_mm": 9.0}, {"grid": 32}):
        assert "not measured" in slide_warning(SlipScene(id="s", title="s", sensor=film | other))


def test_a_pad_on_a_plate_shows_both_models_and_what_linear_elasticity_leaves_out():
    pad = FVSightParameters(support="plate", film_thickness_mm=4.0, film_modulus_mpa=0.3)
    found = explain_press(PressScene(id="p", title="p", objects=("button",), sensor=pad, error_bound={"force": 1.0}), 1)
    assert {one.model for one in found.grids} == {"springs", "layer"}
    assert [one.model for one in found.grids if one.taken] == ["springs"]
    assert "two contact models" in found.models
    assert any(row.name == "finite strain of the film" and "%" in row.why for row in found.effects)
    assert len(found.effects) == n_effects(PressScene(id="p", title="p", sensor=pad))
    assert "finite strain of the film on top" in found.models


def test_a_film_pressed_deeper_than_measured_has_an_unknown_error():
    """No figure of a shallower depth stands in for it."""
    pad = FVSightParameters(support="plate", grid=64, film_thickness_mm=4.0, film_modulus_mpa=0.15)
    scene = PressScene(id="p", title="p", objects=("walnut",), sensor=pad)
    why = next(row.why for row in explain_press(scene, 1).effects if row.name == "finite strain of the film")
    assert re.search(r"pressed to 0\.[3-9]\d of its thickness, deeper than measured \(0\.3\): .* unknown", why)
    assert "%" not in why


def test_samples_spread_over_the_protocol_and_none_is_refused():
    eight = spread(72, 27, 8)
    assert len({index % 27 for index in eight}) == len({index // 27 for index in eight}) == 8
    assert max(eight) < 72 * 27
    assert spread(1, 2, 8) == [0, 1]
    with pytest.raises(ValueError, match="samples"):
        spread(10, 1, 0)


@pytest.mark.slow
def test_a_slide_shows_its_crowns_and_shear():
    scene = SlipScene(id="s", title="s", objects=("cuboid",), motion=SlipMotion(longest_mm=2.0),
                      sensor=FVSightParameters(grid=64), effects=SlideEffects(late_film=False))  # fmt: skip
    found = explain_slide(scene, 1)
    rows = {row.name: row for row in found.effects}
    assert len(rows) == n_slide_effects()
    assert {name.replace("_", " ") for name in SLIDE_FLAGS} < set(rows)
    assert not rows["late film"].on
    assert rows["crowns"].force_n > 1e-3
    assert rows["shear moment"].force_n > 1e-3
    assert rows["camera noise"].force_n == 0
    assert rows["weave moves along"].frame_levels > 0
    assert not rows["partial slip"].on
    assert rows["partial slip"].force_n is None


@pytest.mark.slow
def test_partial_slip_shows_what_one_patch_would_get_wrong():
    pad = FVSightParameters(support="plate", grid=64, film_thickness_mm=4.0, film_modulus_mpa=0.3)
    effects = SlideEffects(partial_slip=True, crowns=False)
    scene = SlipScene(id="s", title="s", objects=("ball",), motion=SlipMotion(longest_mm=2.0),
                      sensor=pad, effects=effects)  # fmt: skip
    found = explain_slide(scene, 1)
    row = found.effects[-1]
    assert (row.name, row.on) == ("partial slip", True)
    assert row.force_n > 1e-3
    assert row.frame_levels > 0.5
    assert "gross slip comes +" in row.why
    assert found.grids[0].model == "layer"
