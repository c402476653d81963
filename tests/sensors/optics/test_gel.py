"""Calibrated gel optics: horizons and terms by geometry, the fit gives back what made the frames."""

import numpy as np
import pytest

from sensors.optics.gel import GelCalibration, GelShader
from sensors.optics.gel_fit import NormalEquations, fit_rest, gather
from sensors.optics.gel_terms import ShadingRecipe, place_terms, surface_terms
from sensors.optics.horizon import horizon_elevation

SHAPE, SURFACE = (60, 80), (100, 120)
FRAME = (slice(20, 80), slice(20, 100))
RECIPE = ShadingRecipe(normal_degree=2, place_degree=1, horizons=4, reach_px=40)


def bump(x0=60.0, y0=50.0, height=8.0, width=9.0) -> np.ndarray:
    y, x = np.mgrid[: SURFACE[0], : SURFACE[1]]
    return height * np.exp(-((x - x0) ** 2 + (y - y0) ** 2) / (2 * width**2))


def calibration(weights=None, recipe=RECIPE, noise=0.0) -> GelCalibration:
    if weights is None:
        weights = np.zeros((recipe.n_surface, recipe.n_place, 3))
    rest = np.zeros((3, 3, 3))
    rest[:, 0, 0] = 120.0
    return GelCalibration(
        sensor="test",
        frame_rows=2 * SHAPE[0],
        frame_columns=2 * SHAPE[1],
        pixel_mm=0.03,
        gel_thickness_mm=3.0,
        gel_poisson=0.49,
        recipe=recipe,
        ridge=0.0,
        weights=np.asarray(weights).tolist(),
        rest=rest.tolist(),
        noise_levels=noise,
        made={},
    )


def test_horizon_of_a_step_is_the_angle_to_its_edge():
    step = np.zeros((8, 100))
    step[:, 70:] = 5.0
    elevation = horizon_elevation(step, 0.0, 60.0)
    for distance in (10, 20, 40):
        # steps grow by a quarter: the edge is met at most that late
        assert np.arctan(5.0 / (1.25 * distance)) <= elevation[4, 70 - distance] <= np.arctan(5.0 / (distance - 0.5))
    assert elevation[4, 75:].max() == 0.0
    assert horizon_elevation(step, np.pi, 60.0)[4, :69].max() == 0.0


def test_horizon_ends_at_its_reach():
    step = np.zeros((8, 100))
    step[:, 70:] = 5.0
    assert horizon_elevation(step, 0.0, 20.0)[4, :45].max() == 0.0


def test_horizon_turns_with_the_surface():
    plain, turned = horizon_elevation(bump(), 0.0, 40.0), horizon_elevation(bump().T, np.pi / 2, 40.0)
    np.testing.assert_allclose(turned.T, plain, atol=1e-5)


def test_terms_of_a_flat_surface_are_zero_wherever_it_lies():
    assert not surface_terms(np.full(SURFACE, 3.0), RECIPE, FRAME).any()


def test_terms_of_a_plane_are_its_normal():
    x = np.arange(SURFACE[1], dtype=float)
    plane = np.broadcast_to(0.5 * x, SURFACE)
    terms = surface_terms(plane, ShadingRecipe(normal_degree=2, horizons=0), FRAME)
    sine = np.sin(np.arctan(0.5))
    middle = terms[:, 30, 40]
    assert middle == pytest.approx([sine, 0, sine**2, 0, 0], abs=1e-5)


def test_number_of_terms_is_as_the_recipe_says():
    for recipe in (RECIPE, ShadingRecipe(), ShadingRecipe(normal_degree=1, place_degree=0, horizons=0)):
        assert len(surface_terms(bump(), recipe, FRAME)) == recipe.n_surface
        assert len(place_terms(SHAPE, recipe)) == recipe.n_place


def test_what_stands_beside_the_frame_casts_its_shadow_into_it():
    beside = bump(x0=10.0, width=3.0)
    recipe = ShadingRecipe(normal_degree=1, horizons=4, reach_px=40)
    shadow = surface_terms(beside, recipe, FRAME)[2 + 2]
    assert shadow[30, 2] > 0.1  # looking along -x, third of four directions


def test_without_a_change_the_rest_frame_is_shown():
    rest = np.random.default_rng(0).integers(0, 256, (120, 160, 3), dtype=np.uint8)
    weights = np.ones((RECIPE.n_surface, RECIPE.n_place, 3))
    assert np.array_equal(GelShader(calibration()).render(bump(), rest), rest)
    assert np.array_equal(GelShader(calibration(weights)).render(np.zeros(SURFACE), rest), rest)
    assert np.array_equal(GelShader(calibration(weights)).render(None, rest), rest)


def test_a_weight_changes_its_channel_alone_and_in_proportion():
    weights = np.zeros((RECIPE.n_surface, RECIPE.n_place, 3))
    weights[0, 0, 1] = 0.5
    change = GelShader(calibration(weights)).relative_change(bump())
    assert not change[..., [0, 2]].any()
    assert change[..., 1].min() == pytest.approx(-change[..., 1].max(), rel=1e-3)
    doubled = GelShader(calibration(2 * weights)).relative_change(bump())
    assert doubled == pytest.approx(2 * change, abs=1e-6)


def test_fit_gives_back_the_weights_that_made_the_light():
    rng = np.random.default_rng(0)
    weights = 0.2 * rng.standard_normal((RECIPE.n_surface, RECIPE.n_place, 3))
    equations = None
    for place in ((40, 40), (60, 50), (80, 60), (50, 65)):
        height = bump(*place)
        terms = np.einsum("syx,pyx->spyx", surface_terms(height, RECIPE, FRAME), place_terms(SHAPE, RECIPE))
        terms = terms.reshape(-1, SHAPE[0] * SHAPE[1]).astype(float)
        target = terms.T @ weights.reshape(-1, 3)
        one = NormalEquations(terms @ terms.T, terms @ target)
        equations = one if equations is None else equations + one
    assert equations is not None
    assert equations.solve(0.0).reshape(weights.shape) == pytest.approx(weights, abs=1e-3)


def test_gathered_frames_fit_to_their_rounding():
    weights = np.zeros((RECIPE.n_surface, RECIPE.n_place, 3))
    weights[0, 0], weights[1, 0], weights[5, 1] = (0.5, -0.2, 0.1), (0.1, 0.4, -0.3), (-0.3, -0.2, -0.4)
    made = GelShader(calibration(weights))
    rest = np.full((120, 160, 3), 120, np.uint8)
    region = (slice(0, SHAPE[0]), slice(0, SHAPE[1]))
    places = ((40, 40), (60, 50), (80, 60), (50, 65))
    parts = [gather(bump(*at), FRAME, made.render(bump(*at), rest), rest, region, RECIPE) for at in places]
    solved = sum(parts[1:], parts[0]).solve(1e-5).reshape(weights.shape)
    again = GelShader(calibration(solved))
    unseen = bump(70, 45)
    difference = again.render(unseen, rest).astype(int) - made.render(unseen, rest)
    assert np.abs(difference).mean() < 0.3


def test_leaving_a_press_out_is_the_fit_of_the_others():
    rng = np.random.default_rng(1)
    parts = []
    for _ in range(3):
        terms, target = rng.standard_normal((5, 50)), rng.standard_normal((50, 3))
        parts.append(NormalEquations(terms @ terms.T, terms @ target))
    whole = parts[0] + parts[1] + parts[2]
    assert (whole - parts[2]).solve(0.1) == pytest.approx((parts[0] + parts[1]).solve(0.1), rel=1e-9)


def test_ridge_shrinks_and_does_not_mind_units():
    rng = np.random.default_rng(2)
    terms, target = rng.standard_normal((4, 60)), rng.standard_normal((60, 3))
    scaled = terms * np.array([1, 10, 0.1, 1000])[:, None]
    plain, other = (NormalEquations(t @ t.T, t @ target).solve(0.05) for t in (terms, scaled))
    assert scaled.T @ other == pytest.approx(terms.T @ plain, rel=1e-9)
    hard = NormalEquations(terms @ terms.T, terms @ target).solve(10.0)
    assert np.linalg.norm(hard) < np.linalg.norm(plain)


def test_an_absent_term_gets_no_weight():
    terms, target = np.vstack((np.ones(30), np.zeros(30))), np.ones((30, 3))
    assert NormalEquations(terms @ terms.T, terms @ target).solve(0.0) == pytest.approx(
        np.array([[1, 1, 1], [0, 0, 0]]), abs=1e-6
    )


def test_rest_fit_gives_back_a_smooth_frame():
    y, x = np.linspace(-1, 1, 120)[:, None], np.linspace(-1, 1, 160)[None, :]
    smooth = np.stack([120 + 30 * x - 20 * y * x, 100 - 25 * x**2 + 0 * y, 90 + 40 * y**3 + 0 * x], axis=-1)
    frame = np.rint(smooth).astype(np.uint8)
    made = calibration().model_copy(update={"rest": fit_rest(frame, 4).tolist()})
    assert np.abs(made.rest_frame().astype(int) - frame).max() <= 1


def test_noise_has_the_stated_size():
    rest = np.full((120, 160, 3), 120, np.uint8)
    shader = GelShader(calibration(noise=2.0))
    noisy = shader.render(None, rest, np.random.default_rng(0)).astype(float)
    assert noisy.std() == pytest.approx(np.sqrt(4 + 1 / 12), rel=0.03)
    assert np.array_equal(shader.render(None, rest, np.random.default_rng(0)), noisy)


def test_a_calibration_survives_its_file(tmp_path):
    rng = np.random.default_rng(0)
    made = calibration(rng.standard_normal((RECIPE.n_surface, RECIPE.n_place, 3)))
    made.save(tmp_path / "made.json")
    assert GelCalibration.load(tmp_path / "made.json") == made


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"sensor": 3}'])
def test_a_file_that_is_none_is_named_in_one_line(tmp_path, text):
    path = tmp_path / "bad.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"bad\.json: not a gel calibration") as failure:
        GelCalibration.load(path)
    assert "\n" not in str(failure.value)


def test_weights_of_another_recipe_are_refused():
    with pytest.raises(ValueError, match="recipe's shape"):
        calibration(np.zeros((2, 2, 3)))


def test_a_surface_smaller_than_the_frame_is_refused():
    with pytest.raises(ValueError, match="cover the frame"):
        GelShader(calibration()).relative_change(np.zeros((50, 80)))
