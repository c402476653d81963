"""Laws of the sparse-coding classifiers KSC and JKSC."""

import pickle
import tracemalloc

import numpy as np
import pytest
from sklearn.neighbors import KNeighborsClassifier

from fusion import JKSC, KSC
from fusion.class_residual import class_residual, class_scores
from fusion.gram import stored_gram
from fusion.kernels import rbf_kernel
from fusion.komp import kernel_omp_gram

MODALITIES = {"image": slice(0, 8), "force": slice(8, 12)}


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
def test_learns_separate_clusters(clusters, model):
    X, y, queries, truth = clusters(spread=0.4)
    assert np.mean(model.fit(X, y).predict(queries) == truth) > 0.9


def test_precomputed_kernel_gives_the_labels_of_the_kernel_itself(clusters):
    X, y, queries, _ = clusters()
    gamma = 0.05
    expected = KSC(gamma=gamma).fit(X, y).predict(queries)
    model = KSC("precomputed").fit(rbf_kernel(X, X, gamma), y)
    np.testing.assert_array_equal(model.predict(rbf_kernel(queries, X, gamma)), expected)


def test_score_is_minus_the_paper_residual_computed_class_by_class(clusters):
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
def test_classes_without_a_selected_atom_score_finitely_below_the_others(clusters, model, monkeypatch):
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
def test_a_narrow_kernel_is_the_nearest_neighbour(clusters, solver):
    X, y, queries, _ = clusters(3, spread=1.5)
    expected = KNeighborsClassifier(1).fit(X, y).predict(queries)
    np.testing.assert_array_equal(KSC(gamma=1e3, solver=solver).fit(X, y).predict(queries), expected)


@pytest.mark.parametrize("gamma", 10.0 ** np.arange(-12, 4))
@pytest.mark.parametrize("model", [KSC(), JKSC(MODALITIES), JKSC(MODALITIES, coupling="independent")], ids=str)
def test_every_kernel_width_has_a_finite_answer(clusters, model, gamma):
    X, y, queries, truth = clusters(4, spread=0.2)
    model = model.set_params(gamma=gamma).fit(X, y)
    assert np.isfinite(model.decision_function(queries)).all()
    assert np.mean(model.predict(queries) == truth) > 0.85


def test_the_shift_changes_no_label(clusters):
    X, y, queries, _ = clusters(5, spread=1.0)
    for gamma in (0.01, 0.1, 0.5):
        kernel = rbf_kernel(queries, X, gamma)
        plain = KSC("precomputed").fit(rbf_kernel(X, X, gamma), y).predict(kernel)
        np.testing.assert_array_equal(KSC(gamma=gamma).fit(X, y).predict(queries), plain)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
@pytest.mark.parametrize("model", both_kinds(), ids=str)
def test_the_unit_of_the_features_changes_no_label(clusters, model, scale):
    X, y, queries, _ = clusters(6)
    expected = model.fit(X, y).predict(queries)
    np.testing.assert_array_equal(model.fit(scale * X, y).predict(scale * queries), expected)


@pytest.mark.parametrize(("scale_g", "scale_k"), [(1e9, 1e9), (1e-9, 1e-9), (1.0, 1e9), (1e9, 1e-9)])
def test_the_scale_of_a_precomputed_kernel_changes_no_label(clusters, scale_g, scale_k):
    X, y, queries, _ = clusters(7)
    G, K = rbf_kernel(X, X, 0.05), rbf_kernel(queries, X, 0.05)
    expected = KSC("precomputed", normalize_kernel=False).fit(G, y).predict(K)
    scaled = KSC("precomputed", normalize_kernel=False).fit(scale_g * G, y).predict(scale_k * K)
    np.testing.assert_array_equal(scaled, expected)


@pytest.mark.parametrize("model", both_kinds(), ids=str)
def test_one_query_at_a_time_equals_the_batch_to_the_bit(clusters, model):
    X, y, queries, _ = clusters(10)
    model = model.fit(X, y)
    single = np.concatenate([model.decision_function(q[None]) for q in queries])
    np.testing.assert_array_equal(single, model.decision_function(queries))


def test_threads_and_pickling_change_no_bit(clusters):
    X, y, queries, _ = clusters(11, n_queries=200)
    expected = JKSC(MODALITIES).fit(X, y).decision_function(queries)
    model = pickle.loads(pickle.dumps(JKSC(MODALITIES, n_jobs=2).fit(X, y)))
    np.testing.assert_array_equal(model.decision_function(queries), expected)


def test_a_training_sample_alone_in_its_class_is_found_again(clusters):
    X, y, _, _ = clusters(12)
    y = y.copy()
    y[0] = 99
    assert KSC().fit(X, y).predict(X[:1]) == [99]


@pytest.mark.parametrize("kernel", ["rbf", "linear"])
def test_values_too_large_to_square_are_refused(clusters, kernel):
    X, y, queries, _ = clusters(19)
    with pytest.raises(ValueError, match="too large to square; scale the features"):
        KSC(kernel).fit(X, y).predict(1e200 * queries)


@pytest.mark.parametrize("kernel", ["rbf", "linear"])
@pytest.mark.parametrize("scale", [1e-160, 1e-300])
def test_values_too_small_to_square_are_refused(clusters, kernel, scale):
    X, y, _, _ = clusters(19)
    with pytest.raises(ValueError, match="too small to square; scale the features"):
        KSC(kernel).fit(scale * X, y)
    with pytest.raises(ValueError, match="too small to square; scale the features"):
        JKSC(MODALITIES, kernel=kernel).fit(np.where(np.arange(12) < 8, 1.0, scale) * X, y)


def test_fit_takes_little_memory_beside_the_gram_matrices(clusters):
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


def test_a_zero_query_of_the_linear_kernel_scores_zero_everywhere(clusters):
    X, y, _, _ = clusters(13)
    model = KSC("linear").fit(X, y)
    np.testing.assert_array_equal(model.decision_function(np.zeros((1, 12))), np.zeros((1, 5)))


def test_copies_of_a_sample_under_two_labels_go_to_the_first_sample(clusters):
    X, y, _, _ = clusters(14)
    doubled, labels = np.concatenate([X, X]), np.concatenate([y, (y + 1) % 5])
    np.testing.assert_array_equal(KSC().fit(doubled, labels).predict(X), y)


@pytest.mark.parametrize("model", both_kinds(), ids=str)
def test_values_that_are_not_finite_are_refused(clusters, model):
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
def test_wrong_settings_are_named(clusters, params, message):
    X, y, _, _ = clusters(16)
    with pytest.raises(ValueError, match=message):
        JKSC(**params).fit(X, y)
