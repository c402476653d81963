"""The pad: rays, springs in closed form, load kept on every layout, friction, frames of the converter."""

import numpy as np
import pytest

from sensors.solids import Ball, Box, HalfSpace
from sensors.taxel_layouts import fingertip_layout, flat_layout, spherical_layout
from sensors.taxel_pad import TaxelPad, TaxelPadParameters

LAYOUTS = ("flat", "sphere", "fingertip")
RNG = np.random.default_rng(0)


def plate(height_m):
    return HalfSpace((0.0, 0.0, height_m), (0.0, 0.0, -1.0))


def ball(height_m):
    return Ball((0.0, 0.0, height_m + 0.015), 0.015)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("solid", [plate, ball])
def test_the_elements_carry_the_load(layout, solid):
    pressed = TaxelPad(TaxelPadParameters(layout=layout)).press(solid, 0.8)
    assert -pressed.vectors[:, 2].sum() == pytest.approx(0.8, rel=1e-6)
    assert (pressed.normal >= 0).all()


def test_a_plate_on_the_flat_pad_is_84_springs_in_parallel():
    pad = TaxelPad()
    pressed = pad.press(plate, 5.0)
    assert pressed.normal == pytest.approx(5.0 / 84, rel=1e-6)
    assert pad.depth(plate(-5e-4)) == pytest.approx(np.full(84, 5e-4))
    sunk = 5.0 / (84 * 300.0)
    assert pad.forces(pad.at_rest(), pad.depth(plate(-sunk)), np.zeros((84, 3)), 1e-3).normal.sum() == pytest.approx(5)


def test_depth_under_a_ball_is_its_shape():
    pad = TaxelPad()
    points = pad.layout.points
    square = points[:, 0] ** 2 + points[:, 1] ** 2
    sphere = 0.015 - np.sqrt(0.015**2 - np.minimum(square, 0.015**2))
    assert pad.depth(ball(-1e-3)) == pytest.approx(np.where(square < 0.015**2, np.maximum(0, 1e-3 - sphere), 0))


@pytest.mark.parametrize(
    "layout", [flat_layout(14, 6, 3.4e-3), spherical_layout(14, 6, 3.4e-3, 0.02), fingertip_layout(14, 6, 3.4e-3, 0.02)]
)
def test_layouts_keep_their_pitch_and_their_frames_are_orthonormal(layout):
    frames = np.concatenate((layout.tangents, layout.normals[:, None]), axis=1)
    assert frames @ np.swapaxes(frames, 1, 2) == pytest.approx(np.broadcast_to(np.eye(3), (84, 3, 3)), abs=1e-12)
    middle = layout.points.reshape(14, 6, 3)[:, 2:4].mean(axis=1)
    chord = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    assert chord == pytest.approx(3.4e-3, rel=0.01)
    assert np.linalg.norm(layout.points[45] - layout.points[44]) == pytest.approx(3.4e-3, rel=0.01)


def test_curved_layouts_lie_on_their_surfaces():
    sphere = spherical_layout(14, 6, 3.4e-3, 0.02)
    assert np.linalg.norm(sphere.points + np.array([0, 0, 0.02]), axis=1) == pytest.approx(0.02)
    tip = fingertip_layout(14, 6, 3.4e-3, 0.02)
    barrel = tip.points[:, 1] < 0
    assert np.hypot(tip.points[barrel, 0], tip.points[barrel, 2] + 0.02) == pytest.approx(0.02)
    assert np.linalg.norm(tip.points[~barrel] + np.array([0, 0, 0.02]), axis=1) == pytest.approx(0.02)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_sliding_plate_drags_with_coulombs_force_and_a_small_shift_with_the_bristles(layout):
    pad = TaxelPad(TaxelPadParameters(layout=layout, damping_ns_per_m=0.0))
    depth, velocity = pad.depth(plate(-3e-4)), np.tile([0.0, 0.05, 0.0], (84, 1))
    bristle = pad.at_rest()
    shifted = pad.forces(bristle, depth, 1e-3 * velocity, 1e-3).vectors[:, 1].sum()
    touching = depth > 0
    for _ in range(200):
        forces = pad.forces(bristle, depth, velocity, 1e-3)
        bristle = forces.bristle
    shear = pad.layout.tangential(forces.vectors)
    assert np.linalg.norm(shear[touching], axis=1) == pytest.approx(0.6 * forces.normal[touching], rel=1e-3)
    if layout == "flat":
        assert forces.vectors[:, 1].sum() == pytest.approx(0.6 * forces.normal.sum(), rel=1e-3)
        assert shifted == pytest.approx(84 * (1000.0 * 5e-8 + 0.3 * 5e-5), rel=1e-2)
    assert (shear[~touching] == 0).all()


def test_retreat_never_pulls():
    pad = TaxelPad(TaxelPadParameters(damping_ns_per_m=50.0))
    leaving = np.tile([0.0, 0.0, 1.0], (84, 1))
    forces = pad.forces(pad.at_rest(), pad.depth(plate(-5e-4)), leaving, 1e-3)
    assert (forces.normal == 0).all()
    assert (forces.vectors == 0).all()


def test_frames_are_steps_of_the_converter_at_its_rate():
    pad = TaxelPad()
    frames = pad.read(RNG.uniform(0, 4, (960, 84)), 960.0)
    assert frames.shape == (240, 84)
    assert frames / pad.step_n == pytest.approx(np.rint(frames / pad.step_n), abs=1e-2)
    assert frames.max() == pytest.approx(250e3 * 3.4e-3**2, rel=1e-3)
    assert pad.image(np.arange(84) * 0.01).shape == (14, 6)


@pytest.mark.parametrize(
    "solid",
    [
        Ball((0.001, -0.002, 0.01), 0.004),
        Box((0, 0, 0.01), (0.003, 0.004, 0.005)),
        HalfSpace((0, 0, 0.004), (0, 0, -1)),
    ],
)
def test_rays_enter_solids_where_marching_does(solid):
    origins = np.concatenate((RNG.uniform(-0.006, 0.006, (40, 2)), np.zeros((40, 1))), axis=1)
    aim = RNG.normal(0, 0.2, (40, 3)) + np.array([0, 0, 1])
    aim /= np.linalg.norm(aim, axis=1, keepdims=True)
    entry = solid.entry(origins, aim)

    def inside(points):
        if isinstance(solid, Ball):
            return np.linalg.norm(points - np.array(solid.centre), axis=-1) < solid.radius
        if isinstance(solid, Box):
            return (np.abs(points - np.array(solid.centre)) < solid.half).all(axis=-1)
        return points[..., 2] > 0.004

    steps = np.arange(0, 0.03, 2e-5)
    hits = inside(origins[:, None] + steps[:, None] * aim[:, None])
    marched = np.where(hits.any(axis=1), steps[hits.argmax(axis=1)], np.inf)
    both = np.isfinite(entry) & np.isfinite(marched)
    assert both.sum() > 10
    assert np.abs(entry[both] - marched[both]).max() < 3e-5
    # a graze may slip between two steps
    assert (np.isfinite(entry) != np.isfinite(marched)).sum() <= 1


def test_a_turned_box_is_met_at_its_corner():
    half = np.sqrt(0.5)
    turn = np.array([[half, 0, half], [0, 1, 0], [-half, 0, half]])
    box = Box((0.0, 0.0, 0.02), (0.005, 0.005, 0.005), turn)
    entry = box.entry(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    assert entry == pytest.approx(0.02 - 0.005 * np.sqrt(2))


def test_what_the_pad_cannot_do_is_refused():
    pad = TaxelPad()
    with pytest.raises(ValueError, match="max_penetration_mm = 2 mm"):
        pad.depth(plate(-2.1e-3))
    with pytest.raises(ValueError, match="N of the 60 N"):
        pad.press(plate, 60.0)
    with pytest.raises(ValueError, match="load_n > 0"):
        pad.press(plate, 0.0)
    with pytest.raises(ValueError, match="past the rim of a hemisphere"):
        _ = TaxelPad(TaxelPadParameters(layout="sphere", radius_mm=5.0)).layout
    with pytest.raises(ValueError, match="or faster"):
        pad.read(np.ones((10, 84)), 100.0)
