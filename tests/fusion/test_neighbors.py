"""Laws of the weighted nearest neighbours."""

import numpy as np
import pytest
from sklearn.neighbors import KNeighborsClassifier

from fusion import WeightedKNN


def clusters(seed=0, n=60, q=30, d=4):
    rng = np.random.default_rng(seed)
    centres = 3 * rng.normal(size=(4, d))
    y, truth = np.arange(n) % 4, np.arange(q) % 4
    return centres[y] + rng.normal(size=(n, d)), y, centres[truth] + rng.normal(size=(q, d)), truth


@pytest.mark.parametrize("k", [1, 3, 10])
def test_equals_scikit_learn_with_exponential_weights(k):
    X, y, queries, _ = clusters()
    reference = KNeighborsClassifier(k, weights=lambda d: np.exp(-d)).fit(X, y)
    model = WeightedKNN(k).fit(X, y)
    np.testing.assert_array_equal(model.predict(queries), reference.predict(queries))
    np.testing.assert_allclose(model.predict_proba(queries), reference.predict_proba(queries), rtol=1e-9)


def test_far_queries_still_go_to_the_nearest_class():
    X, y, queries, _ = clusters(1)
    far = 1e4 * queries / np.linalg.norm(queries, axis=1, keepdims=True)
    proba = WeightedKNN().fit(X, y).predict_proba(far)
    assert np.isfinite(proba).all()
    np.testing.assert_allclose(proba.sum(axis=1), 1)


def test_novelty_is_every_class_sum_below_the_threshold():
    X, y, queries, _ = clusters(2)
    sums = np.zeros((len(queries), 4))
    distances = np.linalg.norm(queries[:, None] - X[None], axis=2)
    for q, row in enumerate(distances):
        for j in np.argsort(row)[:10]:
            sums[q, y[j]] += np.exp(-row[j])
    threshold = float(np.median(sums.max(axis=1)))
    model = WeightedKNN(novelty_threshold=threshold).fit(X, y)
    novel = sums.max(axis=1) < threshold
    assert 0 < novel.sum() < len(novel)
    np.testing.assert_array_equal(model.is_novel(queries), novel)
    expected = np.where(novel, -1, np.argmax(sums, axis=1))
    np.testing.assert_array_equal(model.predict(queries), expected)


def test_raising_the_threshold_never_makes_a_novel_sample_known():
    X, y, queries, _ = clusters(3)
    before = np.zeros(len(queries), dtype=bool)
    for threshold in (0.0, 0.01, 0.1, 0.5, 2.0, 11.0):
        novel = WeightedKNN(novelty_threshold=threshold).fit(X, y).is_novel(queries)
        assert np.all(novel >= before)
        before = novel
    assert before.all()


def test_the_novel_label_follows_the_kind_of_the_labels_or_the_choice():
    X, y, _, _ = clusters(4)
    far = np.full((1, 4), 1e3)
    names = np.array(["silk", "wool", "felt", "jute"])
    strict = {"novelty_threshold": 0.5}
    assert WeightedKNN(**strict).fit(X, y).predict(far).tolist() == [-1]
    assert WeightedKNN(**strict).fit(X, names[y]).predict(far).tolist() == ["unknown"]
    assert WeightedKNN(**strict).fit(X, y - 1).predict(far).tolist() == [-2]
    assert WeightedKNN(**strict, novel_label=99).fit(X, y).predict(far).tolist() == [99]
    with pytest.raises(ValueError, match="is one of the classes"):
        WeightedKNN(**strict, novel_label=3).fit(X, y)


@pytest.mark.parametrize(
    ("labels", "novel"),
    [(np.uint8([0, 255]), -1), (np.uint8([1, 255]), -1), (np.int8([-128, 3]), -129), (np.uint64([0, 2**64 - 1]), -1),
     (np.int64([-(2**63), 0]), -(2**63) - 1)],
)  # fmt: skip
def test_a_novel_sample_gets_no_known_label_whatever_type_the_labels_have(labels, novel):
    model = WeightedKNN(1, novelty_threshold=0.5).fit([[0.0], [10.0]], labels)
    rows = [[0.0], [10.0], [100.0]]
    assert model.is_novel(rows).tolist() == [False, False, True]
    assert model.predict(rows).tolist() == [*labels.tolist(), novel]
    assert model.predict(rows[:1]).dtype == model.predict(rows).dtype


def test_distances_that_no_number_holds_are_refused():
    X, y, queries, _ = clusters()
    with pytest.raises(ValueError, match="too large to square; scale the features"):
        WeightedKNN().fit(X, y).predict_proba(1e160 * queries)


def test_classes_added_one_at_a_time_end_as_all_at_once():
    X, y, queries, _ = clusters(5)
    order = np.argsort(y, kind="stable")
    model = WeightedKNN()
    for label in range(4):
        model.partial_fit(X[y == label], y[y == label])
        assert model.classes_.tolist() == list(range(label + 1))
    whole = WeightedKNN().fit(X[order], y[order])
    np.testing.assert_array_equal(model.predict_proba(queries), whole.predict_proba(queries))


def test_a_novel_class_is_known_once_it_has_been_fitted():
    X, y, queries, truth = clusters(6)
    model = WeightedKNN(novelty_threshold=1e-3).fit(X[y < 3], y[y < 3])
    fresh = truth == 3
    assert model.is_novel(1.0 + 50 * queries[fresh]).all()
    model.partial_fit(1.0 + 50 * queries[fresh], truth[fresh])
    np.testing.assert_array_equal(model.predict(1.0 + 50 * queries[fresh]), 3)


def test_one_query_at_a_time_equals_the_batch_to_the_bit():
    X, y, queries, _ = clusters(7)
    model = WeightedKNN().fit(X, y)
    single = np.concatenate([model.predict_proba(q[None]) for q in queries])
    np.testing.assert_array_equal(single, model.predict_proba(queries))


def test_fewer_samples_than_neighbours_use_all_of_them():
    model = WeightedKNN(10).fit([[0.0], [1.0], [5.0]], [0, 1, 1])
    weights = np.exp(-np.array([0.2, 0.8, 4.8]))
    expected = np.array([weights[0], weights[1] + weights[2]]) / weights.sum()
    np.testing.assert_allclose(model.predict_proba([[0.2]])[0], expected)


@pytest.mark.parametrize(
    "params",
    [
        {"n_neighbors": 0},
        {"n_neighbors": 2.5},
        {"n_neighbors": True},
        {"novelty_threshold": -1.0},
        {"novelty_threshold": "x"},
    ],
    ids=str,
)
def test_wrong_settings_are_named(params):
    with pytest.raises(ValueError, match=next(iter(params))):
        WeightedKNN(**params).fit([[0.0], [1.0]], [0, 1])
