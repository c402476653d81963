"""Laws of joint coding: several modalities, their weights and their columns."""

import numpy as np
import pytest

from fusion import JKSC, KSC
from fusion.class_residual import class_residual, class_scores
from fusion.features import ModalityPCA
from fusion.gram import stored_gram
from fusion.kernels import rbf_kernel
from fusion.komp import joint_komp

MODALITIES = {"image": slice(0, 8), "force": slice(8, 12)}


@pytest.mark.parametrize("solver", ["komp", "lasso"])
@pytest.mark.parametrize("kernel", ["rbf", "linear"])
@pytest.mark.parametrize("coupling", ["shared", "independent"])
def test_joint_coding_of_one_modality_is_kernel_sparse_coding_to_the_bit(clusters, solver, kernel, coupling):
    X, y, queries, _ = clusters()
    expected = KSC(kernel, solver=solver).fit(X, y).decision_function(queries)
    for modalities in (None, {"all": slice(0, 12)}):
        model = JKSC(modalities, coupling=coupling, kernel=kernel, solver=solver)
        np.testing.assert_array_equal(model.fit(X, y).decision_function(queries), expected)


@pytest.mark.parametrize("coupling", ["shared", "independent"])
@pytest.mark.parametrize("gammas", [(0.02, 0.02), (0.01, 0.3), (0.4, 0.005)], ids=str)
def test_joint_scores_are_those_of_unshifted_kernels_times_one_factor_a_query(clusters, coupling, gammas):
    """A shift of its own in each modality would weigh the modalities anew for every query."""
    X, y, queries, _ = clusters(20, spread=1.2)
    weights = [1.0, 0.6]
    joint = JKSC(MODALITIES, coupling=coupling, gamma=dict(zip(MODALITIES, gammas, strict=True)))
    joint = joint.set_params(weights=dict(zip(MODALITIES, weights, strict=True))).fit(X, y)
    parts = [(X[:, c], queries[:, c], g) for c, g in zip(MODALITIES.values(), gammas, strict=True)]
    grams = [rbf_kernel(x, x, g) for x, _, g in parts]
    kernels = np.stack([rbf_kernel(q, x, g) for x, q, g in parts])
    residual, has_atom = np.zeros((len(queries), 5)), np.zeros((len(queries), 5), dtype=bool)
    for members in [[0, 1]] if coupling == "shared" else [[0], [1]]:
        gram, k, w = stored_gram([grams[m] for m in members]), kernels[members], [weights[m] for m in members]
        codes, _ = joint_komp(gram, k, 10, weights=w)
        part, found = class_residual(gram, k, codes.indices, codes.coefs, y, 5, w)
        residual, has_atom = residual + part, has_atom | found
    scores = joint.decision_function(queries)
    factor = kernels.max(axis=(0, 2))[:, None] ** 2
    np.testing.assert_allclose((scores * factor)[has_atom], -residual[has_atom], rtol=1e-7, atol=1e-12)
    np.testing.assert_array_equal(joint.predict(queries), np.argmax(class_scores(residual, has_atom), axis=1))


def test_the_scale_of_one_modality_changes_no_label(clusters):
    X, y, queries, _ = clusters(7)
    scale = np.where(np.arange(12) < 8, 1e6, 1.0)
    for kernel in ("rbf", "linear"):
        model = JKSC(MODALITIES, kernel=kernel)
        expected = model.fit(X, y).predict(queries)
        np.testing.assert_array_equal(model.fit(X * scale, y).predict(queries * scale), expected)


@pytest.mark.parametrize("coupling", ["shared", "independent"])
def test_only_the_ratio_of_weights_counts(clusters, coupling):
    X, y, queries, _ = clusters(17, spread=1.2)
    model = JKSC(MODALITIES, coupling=coupling, weights={"image": 0.5, "force": 2.0}).fit(X, y)
    np.testing.assert_array_equal(model.predict(queries, weights={"image": 4.0, "force": 16.0}), model.predict(queries))
    assert (model.predict(queries, weights={"image": 2.0, "force": 0.01}) != model.predict(queries)).any()


@pytest.mark.parametrize("kernel", ["rbf", "linear"])
@pytest.mark.parametrize("coupling", ["shared", "independent"])
def test_taxels_that_all_read_the_same_leave_the_labels_to_the_image(clusters, kernel, coupling):
    X, y, queries, _ = clusters(18)
    X[:, 8:], queries[:, 8:] = 0.0, 0.0
    joint = JKSC(MODALITIES, kernel=kernel, coupling=coupling).fit(X, y)
    alone = KSC(kernel).fit(X[:, :8], y)
    assert np.isfinite(joint.decision_function(queries)).all()
    agreement = np.mean(joint.predict(queries) == alone.predict(queries[:, :8]))
    if kernel == "linear":
        assert agreement == 1
    elif coupling == "shared":
        assert agreement > 0.7
    else:  # a code of its own speaks for the class of the first atom, and no image outweighs it
        np.testing.assert_array_equal(joint.predict(queries), y[0])


@pytest.mark.parametrize("coupling", ["shared", "independent"])
def test_a_modality_of_weight_zero_is_as_if_it_were_not_there(clusters, coupling):
    X, y, queries, _ = clusters(8)
    model = JKSC(MODALITIES, coupling=coupling).fit(X, y)
    alone = KSC().fit(X[:, :8], y).decision_function(queries[:, :8])
    fitted = JKSC(MODALITIES, coupling=coupling, weights={"force": 0}).fit(X, y)
    for dead in (1e6, np.nan, np.inf):
        noisy = queries.copy()
        noisy[:, 8:] = dead
        np.testing.assert_array_equal(model.decision_function(noisy, weights={"force": 0}), alone)
        np.testing.assert_array_equal(fitted.decision_function(noisy), alone)
        assert np.isnan(noisy[0, 8]) == np.isnan(dead)  # what the caller holds is left alone
    noisy[0, 3] = np.nan
    with pytest.raises(ValueError, match="NaN"):
        model.predict(noisy, weights={"force": 0})


def test_columns_that_two_modalities_share_are_looked_at_while_one_of_them_is_there(clusters):
    X, y, queries, _ = clusters(8)
    model = JKSC({"image": slice(0, 8), "force": slice(6, 12)}).fit(X, y)
    dead = queries.copy()
    dead[:, 8:] = np.nan
    alone = KSC().fit(X[:, :8], y).decision_function(queries[:, :8])
    np.testing.assert_array_equal(model.decision_function(dead, weights={"force": 0}), alone)
    dead[:, 7] = np.nan
    with pytest.raises(ValueError, match="NaN"):
        model.predict(dead, weights={"force": 0})


@pytest.mark.parametrize("coupling", ["shared", "independent"])
def test_weights_at_predict_leave_those_of_modalities_that_they_do_not_name(clusters, coupling):
    X, y, queries, _ = clusters(21, spread=1.2)
    parts = {"a": slice(0, 5), "b": slice(5, 9), "c": slice(9, 12)}
    model = JKSC(parts, coupling=coupling, weights={"a": 5, "b": 0.1}).fit(X, y)
    scores = model.decision_function(queries, weights={"c": 0})
    np.testing.assert_array_equal(scores, model.decision_function(queries, weights={"a": 5, "b": 0.1, "c": 0}))
    assert not np.array_equal(scores, model.decision_function(queries, weights={"a": 1, "b": 1, "c": 0}))
    np.testing.assert_array_equal(model.decision_function(queries, weights={}), model.decision_function(queries))


def masks():
    image = np.arange(12) < 8
    return {"image": image, "force": (~image).tolist()}


@pytest.mark.parametrize(
    "given",
    [
        masks(),
        {"image": range(8), "force": np.arange(8, 12, dtype=np.uint8)},
        {"image": slice(None, -4), "force": slice(-4, None)},
    ],
    ids=["masks", "numbers", "slices"],
)
def test_columns_are_the_same_however_they_are_given(clusters, given):
    X, y, queries, _ = clusters(22)
    expected = JKSC(MODALITIES).fit(X, y).decision_function(queries)
    np.testing.assert_allclose(JKSC(given).fit(X, y).decision_function(queries), expected, rtol=1e-9, atol=1e-12)
    assert ModalityPCA(given).fit(X).transform(X).shape == (len(X), 12)


def test_independent_coding_sums_the_residuals_of_separate_models():
    rng = np.random.default_rng(9)
    X, queries = rng.normal(size=(30, 60)), rng.normal(size=(10, 60))
    y = np.arange(30) % 3
    modalities = {"image": slice(0, 40), "force": slice(40, 60)}
    joint = JKSC(modalities, coupling="independent", kernel="linear", n_nonzero_coefs=15).fit(X, y)
    single = KSC("linear", n_nonzero_coefs=15)
    parts = [single.fit(X[:, c], y).decision_function(queries[:, c]) for c in modalities.values()]
    np.testing.assert_allclose(joint.decision_function(queries), parts[0] + parts[1], atol=1e-12)
