"""Every exported estimator answers as itself: labels, scores, one by one as together, standard operators only."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import onnx
import onnxruntime
import pytest
from sklearn.decomposition import PCA, IncrementalPCA
from sklearn.linear_model import LogisticRegression, RidgeClassifier
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.semi_supervised import LabelSpreading
from sklearn.svm import SVC, LinearSVC

import fusion.onnx.kernels
from fusion import JKSC, KSC, WeightedKNN
from fusion.features import ModalityPCA
from fusion.neural import LateFusionNet
from fusion.onnx import EXPORTERS, add_estimator, class_path
from fusion.onnx.builder import STANDARD_DOMAINS, Graph
from fusion.onnx.ends import float_input, score_output

CLASSES, WIDTH = 7, 14
GROUPS = {"image": slice(0, 9), "force": slice(9, WIDTH)}
ESTIMATORS = {
    "ksc": KSC(gamma=1.0, n_nonzero_coefs=6),
    "ksc few": KSC(gamma=0.25, n_nonzero_coefs=4),
    "ksc narrow": KSC(gamma=1000.0, n_nonzero_coefs=3),
    "ksc wide": KSC(gamma=1e-4, n_nonzero_coefs=6),
    "ksc linear beyond the rank": KSC("linear", n_nonzero_coefs=16),
    "ksc linear plain": KSC("linear", normalize_kernel=False, n_nonzero_coefs=3),
    "jksc": JKSC(GROUPS, gamma=1.0, weights={"image": 1.0, "force": 0.25}, n_nonzero_coefs=4),
    "jksc independent": JKSC(GROUPS, gamma=0.5, coupling="independent", n_nonzero_coefs=4),
    "jksc without force": JKSC(GROUPS, weights={"force": 0.0}, n_nonzero_coefs=3),
    "knn": KNeighborsClassifier(5, algorithm="brute"),
    "knn by distance": KNeighborsClassifier(5, weights="distance"),
    "wknn": WeightedKNN(5),
    "svm": SVC(C=10.0, gamma=1.0),
    "svm linear": SVC(kernel="linear", break_ties=True),
    "linear svm": LinearSVC(),
    "ridge": RidgeClassifier(),
    "pipeline": make_pipeline(StandardScaler(), ModalityPCA(GROUPS, 4), IncrementalPCA(3), WeightedKNN()),
    "whitened": make_pipeline(PCA(3, whiten=True), SVC()),
    "skl2onnx": make_pipeline(PCA(5), LogisticRegression(max_iter=1000)),
}


def samples(n, seed, classes=CLASSES):
    rng = np.random.default_rng(seed)
    y = np.arange(n) % classes
    X = np.random.default_rng(0).standard_normal((classes, WIDTH))[y] + 0.7 * rng.standard_normal((n, WIDTH))
    return (X / 4).astype(np.float32), y


@dataclass
class Exported:
    estimator: object
    model: onnx.ModelProto
    session: object

    def __call__(self, X):
        return self.session.run(["scores"], {"force": np.asarray(X, np.float32)})[0]


def export(estimator, n_classes=None):
    graph = Graph()
    x, finite = float_input(graph, "force", ["N", WIDTH])
    known = estimator.classes_.tolist()
    score_output(graph, add_estimator(graph, estimator, x), known, n_classes or len(known), [finite])
    model = graph.model("pipeline")
    return Exported(estimator, model, onnxruntime.InferenceSession(model.SerializeToString()))


@cache
def exported(name):
    return export(ESTIMATORS[name].fit(*samples(90, 1)))


def scores_of(estimator, X):
    """As the graph gives them: the class that `predict` answers is the first largest."""
    linear = class_path(estimator).startswith("sklearn.pipeline") and hasattr(estimator, "predict_proba")
    score = estimator.predict_proba if linear or not hasattr(estimator, "decision_function") else None
    scores = np.array((score or estimator.decision_function)(X))
    scores[np.arange(len(X)), np.searchsorted(estimator.classes_, estimator.predict(X))] = scores.max(axis=1)
    return scores


@pytest.mark.parametrize("name", ESTIMATORS)
def test_labels_and_scores_are_the_estimators(name):
    made = exported(name)
    X, _ = samples(300, 2)
    expected, found = scores_of(made.estimator, X), made(X)
    best = np.sort(expected, axis=1)
    tied = best[:, -1] - best[:, -2] <= 1e-6 * np.abs(best).max(axis=1)
    assert tied.mean() < 0.5
    np.testing.assert_array_equal(found.argmax(axis=1)[~tied], made.estimator.predict(X)[~tied])
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_sample_alone_scores_as_in_a_batch(name):
    made = exported(name)
    X, _ = samples(100, 3)
    np.testing.assert_allclose(np.concatenate([made(x[None]) for x in X]), made(X), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_what_is_not_finite_and_only_that_scores_nan(name):
    made = exported(name)
    X, _ = samples(6, 4)
    clean = made(X)
    for row, bad in enumerate([np.nan, np.inf, -np.inf]):
        X[row, row] = bad
    X[4] = 3e38
    found = made(X)
    assert np.isnan(found[:3]).all()
    assert np.isfinite(found[3:]).all()
    np.testing.assert_allclose(found[[3, 5]], clean[[3, 5]], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_the_file_holds_standard_operators_and_no_loop(name):
    model = exported(name).model
    onnx.checker.check_model(model, full_check=True)
    assert {node.domain for node in model.graph.node} <= set(STANDARD_DOMAINS)
    assert not {"Loop", "Scan", "If"} & {node.op_type for node in model.graph.node}
    if name != "skl2onnx":
        assert {node.domain for node in model.graph.node} == {""}


@pytest.mark.parametrize(
    "estimator", [KSC(), JKSC(GROUPS, n_nonzero_coefs=3), KNeighborsClassifier(3), WeightedKNN(3), SVC()]
)
def test_queries_that_are_training_samples(estimator):
    X, y = samples(60, 5)
    made = export(estimator.fit(X, y))
    np.testing.assert_array_equal(made(X).argmax(axis=1), estimator.predict(X))


@pytest.mark.parametrize(
    "estimator",
    [
        KSC(n_nonzero_coefs=4),
        KSC("linear", n_nonzero_coefs=2, normalize_kernel=False),
        JKSC(GROUPS, n_nonzero_coefs=4),
        SVC(),
        WeightedKNN(3),
        LateFusionNet(GROUPS, epochs=2, validation_folds=0),
    ],
)
def test_two_classes(estimator):
    """A decision of two classes is one number: the graph writes minus and plus half of it."""
    X, y = samples(40, 6, classes=2)
    made = export(estimator.fit(X, y))
    queries, _ = samples(50, 7, classes=2)
    found = made(queries)
    np.testing.assert_array_equal(found.argmax(axis=1), estimator.predict(queries))
    if hasattr(estimator, "decision_function"):
        apart = estimator.decision_function(queries)
        np.testing.assert_allclose(found, np.stack([-apart, apart], 1) / 2, rtol=1e-5, atol=1e-6)


def test_classes_that_training_did_not_hold_score_finitely_below_all_others():
    X, y = samples(60, 8, classes=3)
    estimator = KSC(n_nonzero_coefs=4).fit(X, np.array([1, 3, 4])[y])
    found = export(estimator, n_classes=6)(X)
    assert np.isfinite(found).all()
    assert (found[:, [0, 2, 5]].max(axis=1) < found[:, [1, 3, 4]].min(axis=1)).all()
    np.testing.assert_array_equal(found.argmax(axis=1), estimator.predict(X))


@pytest.mark.parametrize("kernel", ["rbf", "linear"])
def test_gram_rows_computed_from_the_atoms_are_those_that_are_stored(monkeypatch, kernel):
    X, y = samples(90, 9)
    estimator = JKSC(GROUPS, kernel=kernel, gamma=1.0, n_nonzero_coefs=3).fit(X, y)
    queries, _ = samples(60, 10)
    stored = export(estimator)
    monkeypatch.setattr(fusion.onnx.kernels, "STORED_ATOMS", 10)
    computed = export(estimator)
    assert computed.model.ByteSize() < stored.model.ByteSize()
    np.testing.assert_allclose(computed(queries), stored(queries), rtol=1e-5, atol=1e-6)


def test_vote_ties_of_one_against_one_go_where_predict_puts_them():
    rng = np.random.default_rng(11)
    X, y = rng.standard_normal((60, WIDTH)).astype(np.float32), np.arange(60) % 6
    estimator = SVC(gamma=0.1, C=10.0).fit(X, y)
    queries = rng.standard_normal((3000, WIDTH)).astype(np.float32)
    predicted = estimator.predict(queries)
    assert (estimator.decision_function(queries).argmax(axis=1) != predicted).any()
    np.testing.assert_array_equal(export(estimator)(queries).argmax(axis=1), predicted)


@pytest.mark.parametrize(
    ("estimator", "use"),
    [
        (KSC(solver="lasso"), "use solver='komp'"),
        (KSC("precomputed"), "use kernel='rbf'"),
        (SVC(kernel="poly"), "use 'rbf' or 'linear'"),
        (WeightedKNN(novelty_threshold=0.1), "novelty_threshold=None"),
        (KNeighborsClassifier(3, metric="manhattan"), "metric='manhattan' is not exported; use Euclidean"),
        (KNeighborsClassifier(3, p=1), "metric='minkowski', p=1 is not exported; use Euclidean"),
        (KNeighborsClassifier(3, p=3), "metric='minkowski', p=3 is not exported; use Euclidean"),
    ],
)
def test_what_cannot_be_exact_is_refused_with_what_to_use_instead(estimator, use):
    X, y = samples(30, 12)
    X = X @ X.T if getattr(estimator, "kernel", "") == "precomputed" else X
    with pytest.raises(ValueError, match=use) as refused:
        export(estimator.fit(X, y))
    assert "\n" not in str(refused.value)


class Subclass(KSC):
    """May answer otherwise, so it has no exporter."""


def test_somebodys_own_class_is_refused_until_it_is_registered():
    estimator = Subclass(n_nonzero_coefs=3).fit(*samples(30, 13))
    with pytest.raises(ValueError, match=r"register one in fusion\.onnx\.EXPORTERS"):
        export(estimator)
    EXPORTERS[class_path(estimator)] = "fusion.onnx.sparse:sparse_coding"
    try:
        X, _ = samples(20, 14)
        np.testing.assert_array_equal(export(estimator)(X).argmax(axis=1), estimator.predict(X))
    finally:
        del EXPORTERS[class_path(estimator)]


@pytest.mark.parametrize("estimator", [LinearSVC(), RidgeClassifier(), RidgeClassifier(fit_intercept=False)])
def test_a_linear_decision_between_two_classes_is_halved(estimator):
    X, y = samples(60, 17, classes=2)
    estimator.fit(X, y)
    scores = export(estimator)(X)
    np.testing.assert_array_equal(scores.argmax(axis=1), estimator.predict(X))
    np.testing.assert_allclose(scores[:, 1] - scores[:, 0], estimator.decision_function(X), rtol=1e-5, atol=1e-7)


def test_a_class_that_skl2onnx_does_not_convert_is_refused_in_one_line():
    with pytest.raises(ValueError, match="skl2onnx does not convert it") as refused:
        export(LabelSpreading().fit(*samples(30, 15)))
    assert "\n" not in str(refused.value)
