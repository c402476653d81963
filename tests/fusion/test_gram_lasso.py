"""Laws of the l1 solver."""

import numpy as np
import pytest
from sklearn.linear_model import Lasso, MultiTaskLasso

from fusion import gram_lasso


def lasso(grams, kernels, penalty, **limits):
    return gram_lasso(grams, kernels, penalty, **limits)


def dense(codes, n):
    full = np.zeros((codes.coefs.shape[0], len(codes.indices), n))
    for m, q in np.ndindex(full.shape[:2]):
        used = codes.indices[q] >= 0
        full[m, q, codes.indices[q, used]] = codes.coefs[m, q, used]
    return full


@pytest.mark.parametrize("penalty", [0.05, 0.3, 0.9])
def test_equals_the_lasso_of_scikit_learn_on_a_linear_kernel(penalty):
    rng = np.random.default_rng(0)
    D, s = rng.normal(size=(30, 50)), rng.normal(size=(4, 50))
    codes = dense(lasso([D @ D.T], [s @ D.T], penalty, tol=1e-10, max_sweeps=5000), 30)[0]
    for query, x in zip(s, codes, strict=True):
        weight = penalty * np.abs(D @ query).max() / len(query)
        expected = Lasso(alpha=weight, fit_intercept=False, tol=1e-12, max_iter=100_000).fit(D.T, query).coef_
        np.testing.assert_allclose(x, expected, atol=1e-7)


def test_joint_codes_equal_the_multi_task_lasso_where_modalities_share_a_dictionary():
    rng = np.random.default_rng(1)
    D, s = rng.normal(size=(20, 40)), rng.normal(size=(2, 40))
    G, correlations = D @ D.T, s @ D.T
    codes = lasso([G, G], [correlations[:1], correlations[1:]], 0.2, tol=1e-10, max_sweeps=5000)
    weight = 0.2 * np.linalg.norm(correlations, axis=0).max() / 40
    expected = MultiTaskLasso(alpha=weight, fit_intercept=False, tol=1e-12, max_iter=100_000).fit(D.T, s.T).coef_
    np.testing.assert_allclose(dense(codes, 20)[:, 0], expected, atol=1e-7)


def test_weights_count_like_copies_of_a_modality():
    rng = np.random.default_rng(2)
    grams, kernels = [], []
    for _ in range(2):
        D, s = rng.normal(size=(15, 30)), rng.normal(size=(3, 30))
        grams.append(D @ D.T)
        kernels.append(s @ D.T)
    weighted = lasso(grams, kernels, 0.3, weights=[2.0, 1.0], tol=1e-10)
    copied = lasso([grams[0], *grams], [kernels[0], *kernels], 0.3, tol=1e-10)
    np.testing.assert_allclose(dense(weighted, 15), dense(copied, 15)[1:], atol=1e-7)


def test_other_queries_change_no_bit():
    rng = np.random.default_rng(3)
    D, s = rng.normal(size=(25, 10)), rng.normal(size=(6, 10))
    together = dense(lasso([D @ D.T], [s @ D.T], 0.1), 25)[0]
    for q, kernel in enumerate(s @ D.T):
        alone = dense(lasso([D @ D.T], [kernel[None]], 0.1), 25)[0, 0]
        np.testing.assert_array_equal(alone, together[q])


def test_zero_queries_and_zero_atoms_stay_out():
    D = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 2.0]])
    s = np.array([[0.0, 0.0], [1.0, 1.0]])
    codes = lasso([D @ D.T], [s @ D.T], 0.1)
    assert codes.n_selected[0] == 0
    assert not np.any(codes.indices == 1)
    assert np.isfinite(codes.coefs).all()


@pytest.mark.parametrize("penalty", [0.0, 1.0, -0.1, np.nan])
def test_a_penalty_outside_its_range_is_refused(penalty):
    with pytest.raises(ValueError, match="penalty must lie between 0 and 1"):
        lasso([np.eye(2)], [np.ones((1, 2))], penalty)
