"""Laws of the error ellipsoids."""

import numpy as np
import pytest

from fusion.ellipsoids import ellipsoid_scale, error_ellipsoids


@pytest.mark.parametrize(
    ("confidence", "two", "three"), [(0.5, 1.177, 1.538), (0.9, 2.146, 2.5), (0.95, 2.448, 2.795), (0.99, 3.035, 3.368)]
)
def test_scale_equals_the_published_table(confidence, two, three):
    assert ellipsoid_scale(confidence, 2) == pytest.approx(two, abs=6e-4)
    assert ellipsoid_scale(confidence, 3) == pytest.approx(three, abs=6e-4)


@pytest.mark.parametrize("confidence", [0.5, 0.9, 0.99])
def test_holds_its_share_of_a_normal_class(confidence):
    rng = np.random.default_rng(0)
    mix = rng.normal(size=(3, 3))
    X = rng.normal(size=(20_000, 3)) @ mix + [1.0, 2.0, 3.0]
    ellipsoid = error_ellipsoids(X, np.zeros(len(X), int), confidence=confidence)[0]
    assert np.mean(ellipsoid.contains(X)) == pytest.approx(confidence, abs=0.01)


def test_axes_are_orthonormal_and_rebuild_the_covariance():
    rng = np.random.default_rng(1)
    X = rng.normal(size=(50, 4)) @ rng.normal(size=(4, 4))
    ellipsoid = error_ellipsoids(X, ["a"] * 50)["a"]
    np.testing.assert_allclose(ellipsoid.axes @ ellipsoid.axes.T, np.eye(4), atol=1e-12)
    variances = (ellipsoid.radii / ellipsoid.k) ** 2
    np.testing.assert_allclose(ellipsoid.axes.T @ np.diag(variances) @ ellipsoid.axes, np.cov(X.T), rtol=1e-10)
    assert np.all(np.diff(ellipsoid.radii) <= 0)


def test_the_tips_of_the_axes_lie_on_the_surface():
    rng = np.random.default_rng(2)
    X = rng.normal(size=(30, 3))
    ellipsoid = error_ellipsoids(X, np.zeros(30))[0.0]
    tips = ellipsoid.axes * ellipsoid.radii[:, None]
    assert ellipsoid.contains(ellipsoid.centre + tips).all()
    assert not ellipsoid.contains(ellipsoid.centre + 1.001 * tips).any()


@pytest.mark.parametrize("n_points", [1, 2, 3, 5])
def test_fewer_points_than_dimensions_give_a_flat_ellipsoid(n_points):
    rng = np.random.default_rng(3)
    X = rng.normal(size=(n_points, 7))
    ellipsoid = error_ellipsoids(X, np.zeros(n_points, int), confidence=0.999)[0]
    assert ellipsoid.rank == n_points - 1
    assert np.isfinite(ellipsoid.axes).all()
    assert ellipsoid.contains(X).all()
    assert not ellipsoid.contains(X + rng.normal(size=7)).any()


def test_points_on_a_line_and_equal_points_stay_finite():
    line = np.outer(np.arange(10.0), [1.0, 2.0, 2.0])
    assert error_ellipsoids(line, np.zeros(10, int))[0].rank == 1
    same = error_ellipsoids(np.full((10, 3), 0.1), np.zeros(10, int))[0]
    assert same.rank == 0
    assert same.contains(np.full((1, 3), 0.1)).all()


def test_each_class_has_its_own_in_order():
    rng = np.random.default_rng(4)
    X, y = rng.normal(size=(40, 2)), np.array(["wool", "silk"])[np.arange(40) % 2]
    found = error_ellipsoids(X, y)
    assert list(found) == ["silk", "wool"]
    for label, ellipsoid in found.items():
        np.testing.assert_allclose(ellipsoid.centre, X[y == label].mean(axis=0))
        assert ellipsoid.n_points == 20


def test_input_that_does_not_fit_is_named():
    with pytest.raises(ValueError, match="one label per row"):
        error_ellipsoids(np.zeros((3, 2)), [0, 1])
    with pytest.raises(ValueError, match="not finite"):
        error_ellipsoids([[np.nan, 1.0]], [0])
    with pytest.raises(ValueError, match="confidence must lie"):
        error_ellipsoids(np.zeros((3, 2)), [0, 1, 1], confidence=95)
    with pytest.raises(ValueError, match="points must have 2 columns"):
        error_ellipsoids(np.eye(2), [0, 0])[0].contains(np.zeros((1, 3)))
