import numpy as np
import pytest

from sensors.objects import forms, outlines, textures

X, Y = np.meshgrid(np.linspace(-6.0, 6.0, 241) + 0.01, np.linspace(-6.0, 6.0, 241) + 0.01)


def test_three_ways_to_the_same_rectangle():
    corners = [(-3.0, -2.0), (3.0, -2.0), (3.0, 2.0), (-3.0, 2.0)]
    assert outlines.polygon(X, Y, corners) == pytest.approx(outlines.box(X, Y, 6.0, 4.0), abs=1e-12)
    square = outlines.regular(X, Y, 4, 5.0)
    assert np.array_equal(square < 0.0, outlines.box(X, Y, 5.0, 5.0) < 0.0)


def test_a_box_rounded_to_the_full_is_a_circle():
    assert outlines.box(X, Y, 4.0, 4.0, 2.0) == pytest.approx(outlines.circle(X, Y, 2.0), abs=1e-12)


@pytest.mark.parametrize(
    "distance",
    [
        outlines.circle(X, Y, 3.0),
        outlines.box(X, Y, 6.0, 4.0, 1.0),
        outlines.star(X, Y, 5, 4.0, 2.0),
        outlines.polyline(X, Y, [(-3.0, 1.0), (0.0, -2.0), (4.0, 0.0)]),
    ],
)
def test_distances_never_grow_faster_than_the_way(distance):
    step = X[0, 1] - X[0, 0]
    assert np.abs(np.diff(distance, axis=0)).max() <= step * (1 + 1e-9)
    assert np.abs(np.diff(distance, axis=1)).max() <= step * (1 + 1e-9)


def test_a_star_has_its_points_where_it_says():
    for k in range(5):
        angle = 2 * np.pi * k / 5 - np.pi / 2
        tip = np.array([[np.cos(angle)], [np.sin(angle)]])
        inside, outside = 3.9 * tip, 4.1 * tip
        assert outlines.star(inside[0], inside[1], 5, 4.0, 2.0) < 0.0
        assert outlines.star(outside[0], outside[1], 5, 4.0, 2.0) > 0.0


def test_extruded_edge_is_a_quarter_circle():
    plate = forms.extrude(np.linspace(-2.0, 0.0, 50, endpoint=False), 5.0, edge=1.0)
    depth = -np.linspace(-2.0, 0.0, 50, endpoint=False)
    rounded = depth < 1.0
    centre_distance = np.hypot(1.0 - depth[rounded], plate[rounded] - 4.0)
    assert centre_distance == pytest.approx(1.0)
    assert plate[~rounded] == pytest.approx(5.0)
    assert forms.extrude(np.array([0.1]), 5.0, edge=1.0) == 0.0


def test_a_turned_ball_is_an_ellipsoid_with_equal_axes():
    x = np.linspace(-3.0, 3.0, 1201)
    knots = list(zip(x.tolist(), np.sqrt(9.0 - x**2).tolist(), strict=True))
    near = np.hypot(X, Y) < 2.8
    ball = forms.ellipsoid(X, Y, (3.0, 3.0, 3.0), 3.0)
    assert forms.turned(X, Y, knots, 3.0)[near] == pytest.approx(ball[near], abs=1e-3)


def test_a_straight_rod_is_a_turned_cylinder():
    inside = np.abs(X) < 4.9
    rod = forms.rod(outlines.segment(X, Y, (-5.0, 0.0), (5.0, 0.0)), 1.5, 1.5)
    cylinder = forms.turned(X, Y, [(-5.0, 1.5), (5.0, 1.5)], 1.5)
    assert rod[inside] == pytest.approx(cylinder[inside], abs=1e-12)


def test_lying_hexagon_is_as_high_as_wide_across_flats():
    y = np.linspace(-6.0, 6.0, 2401)
    section = forms.lying_hexagon(y, 8.0)
    assert section.max() == pytest.approx(8.0)
    assert np.trapezoid(np.maximum(2 * (section - 4.0), 0.0), y) == pytest.approx(np.sqrt(3) / 2 * 64, rel=2e-3)


def test_textures_stay_between_their_bounds_and_repeat():
    s = np.linspace(-10.0, 10.0, 2001)
    ribs = textures.ridges(s, 2.0, 0.3)
    assert (ribs.min(), ribs.max()) == pytest.approx((0.0, 0.3))
    assert textures.ridges(s + 2.0, 2.0, 0.3) == pytest.approx(ribs)
    cuts = textures.grooves(s, 2.0, 0.5, 0.2)
    assert (cuts.min(), cuts.max()) == pytest.approx((-0.2, 0.0))
    assert (cuts < 0.0).mean() == pytest.approx(0.25, abs=0.01)


def test_noise_is_smooth_bounded_and_set_by_its_seed():
    field = textures.noise(X, Y, 2.0, 7)
    assert np.abs(field).max() <= 1.0
    assert field.std() > 0.2
    assert np.abs(np.diff(field, axis=1)).max() < 2.0 * 1.875 * (X[0, 1] - X[0, 0]) / 2.0 + 1e-9
    assert np.array_equal(field, textures.noise(X, Y, 2.0, 7))
    assert not np.array_equal(field, textures.noise(X, Y, 2.0, 8))


def test_marks_are_raised_inside_and_flat_outside():
    assert forms.bump(np.array([-1.0, 0.0, 1.0]), 0.2) == pytest.approx([0.2, 0.1, 0.0])
    figure = textures.figures(X, Y, "20", (2.0, 4.0), 0.4, 0.15)
    assert figure.max() == pytest.approx(0.15)
    assert not figure[np.abs(Y) > 2.5].any()
    zero = textures.figures(X, Y, "0", (2.0, 4.0), 0.4, 0.15)
    assert zero == pytest.approx(textures.figures(-X, Y, "0", (2.0, 4.0), 0.4, 0.15), abs=1e-9)
