"""Nested grids reach the same contact as the finest grid alone."""

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.half_space import HalfSpaceCompliance
from sensors.contact.nested import solve_load_nested
from sensors.contact.solver import NO_SURFACE, solve_load

SIDE = 6e-3


def levels(*sizes):
    return [HalfSpaceCompliance(Grid(n, SIDE), 1e6) for n in sizes]


def ball(n, x0=0.0):
    x, y = Grid(n, SIDE).coordinates()
    return ((x - x0) ** 2 + y**2) / 20e-3


def two_tips(n):
    """A small tip too low for the coarse contact, beside a ball: found by the check beyond the margin."""
    x, y = Grid(n, SIDE).coordinates()
    tip = 1.2e-4 + ((x - 2.6e-3) ** 2 + (y - 2.6e-3) ** 2) / 2e-5
    return np.minimum(ball(n, -1e-3), tip)


def spot(n):
    gap = ball(n)
    gap[:, : n // 3] = NO_SURFACE
    return gap


@pytest.mark.parametrize("make", [ball, two_tips, spot])
@pytest.mark.parametrize("force_n", [1e-3, 0.5])
@pytest.mark.parametrize("sizes", [(16, 32, 64), (8, 16, 32, 64), (64,)])
def test_the_solution_is_that_of_the_finest_grid(make, force_n, sizes):
    gap, nested = make(64), levels(*sizes)
    found = solve_load_nested(nested, gap, force_n, tolerance=1e-7)
    alone = solve_load(nested[-1], gap, force_n, tolerance=1e-7)
    assert found.force_n == pytest.approx(force_n)
    assert found.indentation_m == pytest.approx(alone.indentation_m, rel=1e-4)
    assert np.linalg.norm(found.pressure - alone.pressure) < 1e-3 * np.linalg.norm(alone.pressure)


def test_a_window_that_comes_back_is_not_made_again_and_few_are_kept():
    space = HalfSpaceCompliance(Grid(32, SIDE), 1e6)
    pressure = np.random.default_rng(0).random((32, 32))
    first = space.window(slice(3, 12), slice(5, 20))
    assert space.window(slice(9, 18), slice(0, 15)) is first  # a filter does not depend on the place
    for stop in range(13, 30):
        cut = (slice(3, stop), slice(5, 20))
        inside = np.zeros_like(pressure)
        inside[cut] = pressure[cut]
        found = space.window(*cut).displacement(pressure[cut])
        np.testing.assert_allclose(found, space.displacement(inside)[cut], rtol=1e-12)
    assert space.window(slice(3, 12), slice(5, 20)) is not first


def test_no_load_is_no_contact():
    assert not solve_load_nested(levels(16, 32), ball(32), 0.0).contact.any()


def test_grids_that_do_not_double_are_refused():
    with pytest.raises(ValueError, match=r"must double .* \[16, 48\]"):
        solve_load_nested(levels(16, 48), ball(48), 1.0)
