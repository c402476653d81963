"""Laws of the kernels."""

import numpy as np
import pytest
from sklearn.metrics.pairwise import rbf_kernel as sklearn_rbf

from fusion.kernels import cosine_normalize, linear_kernel, rbf_kernel, resolve_gamma, squared_norms

RNG = np.random.default_rng(0)
X, Y = RNG.normal(size=(9, 13)), RNG.normal(size=(21, 13))


def test_values_equal_the_definitions():
    np.testing.assert_allclose(linear_kernel(X, Y), X @ Y.T, atol=1e-13)
    np.testing.assert_allclose(rbf_kernel(X, Y, 0.1), sklearn_rbf(X, Y, gamma=0.1), rtol=1e-12)
    np.testing.assert_allclose(squared_norms(X), np.sum(X**2, axis=1), rtol=1e-14)


@pytest.mark.parametrize("kernel", [linear_kernel, lambda x, y: rbf_kernel(x, y, 0.3)])
def test_a_pair_has_the_same_bits_whichever_rows_are_beside_it(kernel):
    whole = kernel(X, Y)
    for i, j in np.ndindex(whole.shape):
        assert kernel(X[i : i + 1], Y[j : j + 1])[0, 0] == whole[i, j]


def test_a_row_lies_at_distance_zero_from_itself_even_far_from_the_origin():
    np.testing.assert_array_equal(np.diagonal(rbf_kernel(X + 1e6, X + 1e6, 1.0)), 1.0)


def test_cosine_normalisation_gives_cosines_and_zero_for_zero_rows():
    rows = np.vstack([X, np.zeros(13)])
    K = cosine_normalize(linear_kernel(rows, Y), squared_norms(rows), squared_norms(Y))
    expected = X @ Y.T / np.linalg.norm(X, axis=1)[:, None] / np.linalg.norm(Y, axis=1)
    np.testing.assert_allclose(K[:-1], expected, atol=1e-15)
    np.testing.assert_array_equal(K[-1], 0)


def test_gamma_scale_makes_the_kernel_blind_to_the_unit():
    assert resolve_gamma("scale", 1e3 * X) == pytest.approx(1e-6 * resolve_gamma("scale", X))
    assert resolve_gamma("scale", np.ones((4, 2))) == 1.0


@pytest.mark.parametrize("size", [1e-160, 1e-300])
def test_gamma_scale_of_values_whose_variance_keeps_no_digits_is_refused(size):
    with pytest.raises(ValueError, match="too small to square; scale the features"):
        resolve_gamma("scale", size * X)
    assert resolve_gamma("scale", np.full((4, 2), size)) == 1.0


@pytest.mark.parametrize("gamma", ["auto", 0, -1.0, np.nan, np.inf, None, True])
def test_a_gamma_without_meaning_is_refused(gamma):
    with pytest.raises(ValueError, match="gamma must be 'scale' or a positive finite number"):
        resolve_gamma(gamma, X)
