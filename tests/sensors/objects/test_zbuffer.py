import numpy as np
import pytest

from sensors.objects.mesh import Mesh, box, ellipsoid, lathe, merge, rotation, sweep
from sensors.objects.zbuffer import MeshSurface, rasterise

AXIS = np.arange(-12.0, 12.0, 0.1) + 0.05


def sphere_height(radius, middle, axis=AXIS):
    rest = radius**2 - axis[None, :] ** 2 - axis[:, None] ** 2
    return np.where(rest > 0.0, middle + np.sqrt(np.maximum(rest, 0.0)), 0.0)


def test_sphere_falls_short_by_no_more_than_its_facets():
    """Facets lie inside the ball by about R (pi / segments)^2 / 2 normal to it, so more where it is steep."""
    radius = 10.0
    exact = sphere_height(radius, radius)
    errors = []
    for segments in (48, 96, 192):
        found = rasterise(ellipsoid((0.0, 0.0, radius), (radius,) * 3, segments), AXIS, AXIS)
        gentle = exact > 1.5 * radius
        error = exact - found
        assert error[gentle].min() > -1e-9
        assert error[gentle].max() < 3.0 * radius * (np.pi / segments) ** 2
        errors.append(error[gentle].mean())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.15)


def test_box_is_exact():
    found = rasterise(box((-5.0, -3.0, 1.0), (4.0, 7.0, 6.5)), AXIS, AXIS)
    x, y = AXIS[None, :], AXIS[:, None]
    inside = (x > -5.0) & (x < 4.0) & (y > -3.0) & (y < 7.0)
    assert found == pytest.approx(np.where(inside, 6.5, 0.0), abs=1e-9)


def test_a_large_triangle_gives_its_plane_and_shares_no_cracks_with_its_neighbour():
    corners = np.array([[-11.0, -11, 1], [11, -11, 3], [11, 11, 9], [-11, 11, 7]])
    sheet = rasterise(Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]])), AXIS, AXIS)
    inside = np.abs(AXIS) < 11.0
    plane = 5.0 + AXIS[None, :] / 11.0 + 3.0 * AXIS[:, None] / 11.0
    assert sheet[np.ix_(inside, inside)] == pytest.approx(plane[np.ix_(inside, inside)], abs=1e-9)
    assert not sheet[~inside].any()


def test_union_is_the_higher_of_the_two_and_order_is_of_no_account():
    a, b = box((-5, -5, 0), (5, 5, 3)), ellipsoid((2.0, 0.0, 2.0), (4.0, 4.0, 4.0))
    both = rasterise(merge(a, b), AXIS, AXIS)
    assert np.array_equal(both, rasterise(merge(b, a), AXIS, AXIS))
    assert np.array_equal(both, np.maximum(rasterise(a, AXIS, AXIS), rasterise(b, AXIS, AXIS)))


def test_what_lies_off_the_grid_or_below_the_table_is_left_out():
    assert not rasterise(box((20.0, 20.0, 0.0), (30.0, 30.0, 5.0)), AXIS, AXIS).any()
    assert not rasterise(box((-5.0, -5.0, -3.0), (5.0, 5.0, -1.0)), AXIS, AXIS).any()
    beyond = rasterise(box((-50.0, -50.0, 0.0), (50.0, 50.0, 5.0)), AXIS, AXIS)
    assert beyond == pytest.approx(np.full_like(beyond, 5.0))


def test_turning_the_mesh_turns_the_picture():
    block = box((-8.0, -2.0, 0.0), (3.0, 5.0, 4.0))
    turned = rasterise(block.moved(turn=rotation("z", 90.0)), AXIS, AXIS)
    assert turned == pytest.approx(np.rot90(rasterise(block, AXIS, AXIS), -1), abs=1e-9)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_rotations_are_right_handed(axis):
    first, second, third = {"x": (0, 1, 2), "y": (1, 2, 0), "z": (2, 0, 1)}[axis]
    turn = rotation(axis, 90.0)
    assert turn @ np.eye(3)[second] == pytest.approx(np.eye(3)[third])
    assert turn @ np.eye(3)[first] == pytest.approx(np.eye(3)[first])


def test_a_straight_sweep_and_a_lying_lathe_are_the_same_cylinder():
    tube = rasterise(sweep([(-8.0, 0.0, 3.0), (0.0, 0.0, 3.0), (8.0, 0.0, 3.0)], 3.0, 96), AXIS, AXIS)
    turned = lathe([(3.0, -8.0), (3.0, 8.0)], 96).moved((0.0, 0.0, 3.0), rotation("y", 90.0))
    found = rasterise(turned, AXIS, AXIS)
    y = AXIS[np.abs(AXIS) < 2.5]
    exact = 3.0 + np.sqrt(9.0 - y**2)
    for height in (tube, found):
        assert height[np.abs(AXIS) < 2.5, 120] == pytest.approx(exact, abs=0.01)


def test_mesh_surface_reads_between_its_grid_points():
    surface = MeshSurface(lambda: ellipsoid((1.0, 2.0, 5.0), (5.0, 5.0, 5.0), 384), (10.0, 10.0), (1.0, 2.0))
    points = np.random.default_rng(0).uniform(-2.5, 2.5, (2, 500))
    exact = 5.0 + np.sqrt(25.0 - (points**2).sum(axis=0))
    assert surface(points[0] + 1.0, points[1] + 2.0) == pytest.approx(exact, abs=2e-3)
    assert not surface(np.array([20.0, -20.0]), np.array([0.0, 0.0])).any()
