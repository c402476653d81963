"""Laws of the sparse-coding classifiers KSC and JKSC."""

import pickle
import tracemalloc

import numpy as np
import pytest
from sklearn.neighbors import KNeighborsClassifier

from fusion import JKSC, KSC
from fusion.class_residual import class_residual, class_scores
from fusion.features import ModalityPCA
from fusion.gram import stored_gram
from fusion.kernels import rbf_kernel
from fusion.komp import joint_komp, kernel_omp_gram

MODALITIES = {"image": slice(0, 8), "force": slice(8, 12)}


def clusters(seed=0, n_classes=5, per_class=8, n_queries=40, spread=0.7, d=12):
    rng = np.random.default_rng(seed)
    centres = rng.normal(size=(n_classes, d))
    y = np.arange(n_classes * per_class) % n_classes
    truth = np.arange(n_queries) % n_classes
    return (
        centres[y] + spread * rng.normal(size=(len(y), d)),
        y,
        centres[truth] + spread * rng.normal(size=(n_queries, d)),
        truth,
    )


def both_kinds():
    return [
        KSC(),
        KSC("linear"),
        KSC(solver="lasso"),
        JKSC(MODALITIES),
        JKSC(MODALITIES, coupling="independent"),
        JKSC(MODALITIES, kernel="linear"),
        JKSC(MODALITIES, solver="lasso"),
    ]


@pytest.mark.parametrize("model", both_kinds(), ids=str)
def test_learns_separate_clusters(model):
    X, y, queries, truth = clusters(spread=0.4)
    assert np.mean(model.fit(X, y).predict(queries) == truth) > 0.9


@pytest.mark.parametrize("solver", ["komp", "lasso"])
@pytest.mark.parametrize("kernel", ["rbf", "linear"])
@pytest.mark.parametrize("coupling", ["shared", "independent"])
def test_joint_coding_of_one_modality_is_kernel_sparse_coding_to_the_bit(solver, kernel, coupling):
    X, y, queries, _ = clusters()
    expected = KSC(kernel, solver=solver).fit(X, y).decision_function(queries)
    for modalities in (None, {"all": slice(0, 12)}):
        model = JKSC(modalities, coupling=coupling, kernel=kernel, solver=solver)
        np.testing.assert_array_equal(model.fit(X, y).decision_function(queries), expected)


def test_precomputed_kernel_gives_the_labels_of_the_kernel_itself():
    X, y, queries, _ = clusters()
    gamma = 0.05
    expected = KSC(gamma=gamma).fit(X, y).predict(queries)
    model = KSC("precomputed").fit(rbf_kernel(X, X, gamma), y)
    np.testing.assert_array_equal(model.predict(rbf_kernel(queries, X, gamma)), expected)


def test_score_is_minus_the_paper_residual_computed_class_by_class():
    X, y, queries, _ = clusters(1)
    G, K = rbf_kernel(X, X, 0.1), rbf_kernel(queries, X, 0.1)
    indices, coefs, _, _ = kernel_omp_gram(G, K, 10)
    residual, has_atom = class_residual(stored_gram([G]), K[None], indices, coefs[None], y, 5, [1.0])
    for q in range(len(queries)):
        x = np.zeros(len(X))
        x[indices[q]] = coefs[q]
        for c in range(5):
            part = np.where(y == c, x, 0)
            assert residual[q, c] == pytest.approx(-2 * K[q] @ part + part @ G @ part, abs=1e-12)
            assert has_atom[q, c] == (part != 0).any()


@pytest.mark.parametrize("model", both_kinds(), ids=str)
def test_classes_without_a_selected_atom_score_finitely_below_the_others(model, monkeypatch):
    seen = []
    monkeypatch.setattr(
        "fusion.sparse_coding.class_scores", lambda residual, found: seen.append(found) or class_scores(residual, found)
    )
    X, y, queries, _ = clusters(n_classes=12, per_class=3)
    scores = model.set_params(n_nonzero_coefs=2).fit(X, y).decision_function(queries)
    assert np.isfinite(scores).all()
    found = np.concatenate(seen)
    mixed = found.any(axis=1) & ~found.all(axis=1)
    assert mixed.sum() > 10
    for row, chosen in zip(scores[mixed], found[mixed], strict=True):
        assert row[~chosen].max() < row[chosen].min()


def test_masked_classes_lie_below_every_other_at_any_scale():
    rng = np.random.default_rng(2)
    has_atom = rng.random((50, 6)) < 0.5
    has_atom[0] = False
    for scale in (1e-300, 1.0, 1e18):
        scores = class_scores(scale * rng.normal(size=(50, 6)), has_atom)
        assert np.isfinite(scores).all()
        for row, chosen in zip(scores[1:], has_atom[1:], strict=True):
            if chosen.any() and not chosen.all():
                assert row[~chosen].max() < row[chosen].min()
        np.testing.assert_array_equal(scores[0], 0)


@pytest.mark.parametrize("solver", ["komp", "lasso"])
def test_a_narrow_kernel_is_the_nearest_neighbour(solver):
    X, y, queries, _ = clusters(3, spread=1.5)
    expected = KNeighborsClassifier(1).fit(X, y).predict(queries)
    np.testing.assert_array_equal(KSC(gamma=1e3, solver=solver).fit(X, y).predict(queries), expected)


@pytest.mark.parametrize("gamma", 10.0 ** np.arange(-12, 4))
@pytest.mark.parametrize("model", [KSC(), JKSC(MODALITIES), JKSC(MODALITIES, coupling="independent")], ids=str)
def test_every_kernel_width_has_a_finite_answer(model, gamma):
    X, y, queries, truth = clusters(4, spread=0.2)
    model = model.set_params(gamma=gamma).fit(X, y)
    assert np.isfinite(model.decision_function(queries)).all()
    assert np.mean(model.predict(queries) == truth) > 0.85


@pytest.mark.parametrize("coupling", ["shared", "independent"])
@pytest.mark.parametrize("gammas", [(0.02, 0.02), (0.01, 0.3), (0.4, 0.005)], ids=str)
def test_joint_scores_are_those_of_unshifted_kernels_times_one_factor_a_query(coupling, gammas):
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


def test_the_shift_changes_no_label():
    X, y, queries, _ = clusters(5, spread=1.0)
    for gamma in (0.01, 0.1, 0.5):
        kernel = rbf_kernel(queries, X, gamma)
        plain = KSC("precomputed").fit(rbf_kernel(X, X, gamma), y).predict(kernel)
        np.testing.assert_array_equal(KSC(gamma=gamma).fit(X, y).predict(queries), plain)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
@pytest.mark.parametrize("model", both_kinds(), ids=str)
def test_the_unit_of_the_features_changes_no_label(model, scale):
    X, y, queries, _ = clusters(6)
    expected = model.fit(X, y).predict(queries)
    np.testing.assert_array_equal(model.fit(scale * X, y).predict(scale * queries), expected)


def test_the_scale_of_one_modality_changes_no_label():
    X, y, queries, _ = clusters(7)
    scale = np.where(np.arange(12) < 8, 1e6, 1.0)
    for kernel in ("rbf", "linear"):
        model = JKSC(MODALITIES, kernel=kernel)
        expected = model.fit(X, y).predict(queries)
        np.testing.assert_array_equal(model.fit(X * scale, y).predict(queries * scale), expected)


@pytest.mark.parametrize(("scale_g", "scale_k"), [(1e9, 1e9), (1e-9, 1e-9), (1.0, 1e9), (1e9, 1e-9)])
def test_the_scale_of_a_precomputed_kernel_changes_no_label(scale_g, scale_k):
    X, y, queries, _ = clusters(7)
    G, K = rbf_kernel(X, X, 0.05), rbf_kernel(queries, X, 0.05)
    expected = KSC("precomputed", normalize_kernel=False).fit(G, y).predict(K)
    scaled = KSC("precomputed", normalize_kernel=False).fit(scale_g * G, y).predict(scale_k * K)
    np.testing.assert_array_equal(scaled, expected)


@pytest.mark.parametrize("coupling", ["shared", "independent"])
def test_only_the_ratio_of_weights_counts(coupling):
    X, y, queries, _ = clusters(17, spread=1.2)
    model = JKSC(MODALITIES, coupling=coupling, weights={"image": 0.5, "force": 2.0}).fit(X, y)
    np.testing.assert_array_equal(model.predict(queries, weights={"image": 4.0, "force": 16.0}), model.predict(queries))
    assert (model.predict(queries, weights={"image": 2.0, "force": 0.01}) != model.predict(queries)).any()


@pytest.mark.parametrize("kernel", ["rbf", "linear"])
@pytest.mark.parametrize("coupling", ["shared", "independent"])
def test_taxels_that_all_read_the_same_leave_the_labels_to_the_image(kernel, coupling):
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
def test_a_modality_of_weight_zero_is_as_if_it_were_not_there(coupling):
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


def test_columns_that_two_modalities_share_are_looked_at_while_one_of_them_is_there():
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
def test_weights_at_predict_leave_those_of_modalities_that_they_do_not_name(coupling):
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
def test_columns_are_the_same_however_they_are_given(given):
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


@pytest.mark.parametrize("model", both_kinds(), ids=str)
def test_one_query_at_a_time_equals_the_batch_to_the_bit(model):
    X, y, queries, _ = clusters(10)
    model = model.fit(X, y)
    single = np.concatenate([model.decision_function(q[None]) for q in queries])
    np.testing.assert_array_equal(single, model.decision_function(queries))


def test_threads_and_pickling_change_no_bit():
    X, y, queries, _ = clusters(11, n_queries=200)
    expected = JKSC(MODALITIES).fit(X, y).decision_function(queries)
    model = pickle.loads(pickle.dumps(JKSC(MODALITIES, n_jobs=2).fit(X, y)))
    np.testing.assert_array_equal(model.decision_function(queries), expected)


def test_a_training_sample_alone_in_its_class_is_found_again():
    X, y, _, _ = clusters(12)
    y = y.copy()
    y[0] = 99
    assert KSC().fit(X, y).predict(X[:1]) == [99]


@pytest.mark.parametrize("kernel", ["rbf", "linear"])
def test_values_too_large_to_square_are_refused(kernel):
    X, y, queries, _ = clusters(19)
    with pytest.raises(ValueError, match="too large to square; scale the features"):
        KSC(kernel).fit(X, y).predict(1e200 * queries)


@pytest.mark.parametrize("kernel", ["rbf", "linear"])
@pytest.mark.parametrize("scale", [1e-160, 1e-300])
def test_values_too_small_to_square_are_refused(kernel, scale):
    X, y, _, _ = clusters(19)
    with pytest.raises(ValueError, match="too small to square; scale the features"):
        KSC(kernel).fit(scale * X, y)
    with pytest.raises(ValueError, match="too small to square; scale the features"):
        JKSC(MODALITIES, kernel=kernel).fit(np.where(np.arange(12) < 8, 1.0, scale) * X, y)


def test_fit_takes_little_memory_beside_the_gram_matrices():
    X, y, _, _ = clusters(23, per_class=120)
    models = [KSC(), KSC("linear"), JKSC(MODALITIES, kernel="linear"), JKSC(MODALITIES)]
    for model in models:
        model.fit(X, y)  # compiled from here on
        tracemalloc.start()
        model.fit(X, y)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        one = 8 * len(X) ** 2
        kept = one * len(model._modalities)
        assert kept <= peak < kept + (0.2 if len(model._modalities) == 1 else 1.2) * one


@pytest.mark.parametrize("kernel", ["rbf", "linear"])
def test_constant_features_give_the_first_class(kernel):
    X, y = np.full((9, 4), 3.0), np.arange(9) % 3
    model = KSC(kernel).fit(X, y)
    assert np.isfinite(model.decision_function(X)).all()
    np.testing.assert_array_equal(model.predict(X), 0)


def test_a_zero_query_of_the_linear_kernel_scores_zero_everywhere():
    X, y, _, _ = clusters(13)
    model = KSC("linear").fit(X, y)
    np.testing.assert_array_equal(model.decision_function(np.zeros((1, 12))), np.zeros((1, 5)))


def test_copies_of_a_sample_under_two_labels_go_to_the_first_sample():
    X, y, _, _ = clusters(14)
    doubled, labels = np.concatenate([X, X]), np.concatenate([y, (y + 1) % 5])
    np.testing.assert_array_equal(KSC().fit(doubled, labels).predict(X), y)


@pytest.mark.parametrize("model", both_kinds(), ids=str)
def test_values_that_are_not_finite_are_refused(model):
    X, y, queries, _ = clusters(15)
    queries[3, 2] = np.nan
    with pytest.raises(ValueError, match="NaN"):
        model.fit(X, y).predict(queries)


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"modalities": {"a": slice(0, 13)}}, "do not fit the 12 columns"),
        ({"modalities": {"a": slice(4, 4)}}, "do not fit the 12 columns"),
        ({"modalities": {"a": [0, 12]}}, "do not fit the 12 columns"),
        ({"modalities": {}}, "at least one group"),
        ({"modalities": [slice(0, 8), slice(8, 12)]}, "at least one group"),
        ({"modalities": {"a": [0.6, 1.7]}}, "modality 'a': columns must be"),
        ({"modalities": {"a": [True, False]}}, "modality 'a': columns must be"),
        ({"modalities": {"a": "x"}}, "modality 'a': columns must be"),
        ({"modalities": {"a": None}}, "modality 'a': columns must be"),
        ({"modalities": {"a": [slice(0, 8), slice(8, 12)]}}, "modality 'a': columns must be"),
        ({"modalities": {"a": [[0, 1], [2]]}}, "modality 'a': columns must be"),
        ({"modalities": {"a": slice("x")}}, "modality 'a': columns must be"),
        (
            {"modalities": {0: slice(0, 8), 1: slice(8, 12)}, "weights": {2: 1}},
            "weights name 2; the modalities are 0",
        ),
        ({"modalities": MODALITIES, "weights": {"force": "x"}}, "that of 'force' is 'x'"),
        ({"modalities": MODALITIES, "weights": [1, 2]}, "weights must map"),
        ({"modalities": MODALITIES, "gamma": {"imagee": 3}}, "gamma names imagee; the modalities are image, force"),
        ({"n_nonzero_coefs": 0}, "n_nonzero_coefs must be"),
        ({"n_nonzero_coefs": 2.0}, "n_nonzero_coefs must be"),
        ({"n_nonzero_coefs": True}, "n_nonzero_coefs must be"),
        ({"penalty": 2}, "penalty must lie"),
        ({"penalty": "x"}, "penalty must lie"),
        ({"pivot_tol": 5}, "pivot_tol must be"),
        ({"pivot_tol": "x"}, "pivot_tol must be"),
        ({"n_jobs": 0}, "n_jobs must be"),
        ({"n_jobs": "x"}, "n_jobs must be"),
        ({"max_sweeps": 0}, "max_sweeps must be"),
        ({"tol": -1}, "tol must be"),
        ({"normalize_kernel": "no"}, "normalize_kernel must be"),
        ({"modalities": MODALITIES, "weights": {"sound": 1}}, "weights name sound"),
        ({"modalities": MODALITIES, "weights": {"force": -1}}, "not negative"),
        ({"modalities": MODALITIES, "weights": {"force": 0, "image": 0}}, "not all 0"),
        ({"coupling": "loose"}, "coupling must be"),
        ({"kernel": "cubic"}, "kernel must be one of"),
        ({"solver": "lars"}, "solver must be one of"),
        ({"gamma": 0}, "gamma must be"),
        ({"gamma": "auto"}, "gamma must be"),
        ({"kernel": "precomputed", "modalities": MODALITIES}, "leave modalities=None"),
    ],
)
def test_wrong_settings_are_named(params, message):
    X, y, _, _ = clusters(16)
    with pytest.raises(ValueError, match=message):
        JKSC(**params).fit(X, y)
