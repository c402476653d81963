"""Every registered classifier goes through the same battery, fed two modalities as a run feeds them."""

from functools import cache

import numpy as np
import pytest

from vtbench.run.methods import METHODS

GROUPS = {"image": slice(0, 24), "force": slice(24, 40)}
WEIGHTS = {"image": 1.0, "force": 1.0}
CLASSES = 4


def samples(n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Gaussian classes with mean squared norm 1 a modality, as preprocessing leaves them."""
    means = np.random.default_rng(0).standard_normal((CLASSES, 40))
    y = np.arange(n) % CLASSES
    X = means[y] + 0.5 * np.random.default_rng(seed).standard_normal((n, 40))
    for columns in GROUPS.values():
        X[:, columns] /= np.sqrt((X[:, columns] ** 2).sum(axis=1).mean())
    return X, y


@cache
def fitted(method_id: str):
    """The method fitted once; a test that needs two fits asks for a new one."""
    return newly_fitted(method_id)


def newly_fitted(method_id: str):
    method = METHODS.get(method_id)
    first = {name: values[0] for name, values in method.choices.items()}
    model = method.build(GROUPS, WEIGHTS, first)
    model.fit(*samples(60, 1))
    return model


@pytest.mark.parametrize("method_id", METHODS.ids())
class TestEveryMethod:
    def test_it_learns_separated_classes(self, method_id):
        X, y = samples(40, 2)
        assert (fitted(method_id).predict(X) == y).mean() >= 0.9

    def test_the_same_data_give_the_same_labels(self, method_id):
        X, _ = samples(40, 3)
        assert np.array_equal(fitted(method_id).predict(X), newly_fitted(method_id).predict(X))

    def test_one_by_one_equals_batch(self, method_id):
        X, _ = samples(20, 4)
        model = fitted(method_id)
        assert np.array_equal(model.predict(X), np.concatenate([model.predict(row[None]) for row in X]))

    def test_the_order_of_queries_does_not_matter(self, method_id):
        X, _ = samples(20, 5)
        model, order = fitted(method_id), np.random.default_rng(0).permutation(20)
        assert np.array_equal(model.predict(X)[order], model.predict(X[order]))

    def test_labels_are_those_of_training(self, method_id):
        X, _ = samples(20, 6)
        labels = fitted(method_id).predict(X)
        assert labels.shape == (20,)
        assert set(labels) <= set(range(CLASSES))

    def test_names_of_classes_do_not_matter(self, method_id):
        method = METHODS.get(method_id)
        first = {name: values[0] for name, values in method.choices.items()}
        X, y = samples(60, 1)
        queries, _ = samples(20, 7)
        renamed = method.build(GROUPS, WEIGHTS, first)
        renamed.fit(X, y * 10 + 3)
        assert np.array_equal(renamed.predict(queries), fitted(method_id).predict(queries) * 10 + 3)

    @pytest.mark.parametrize("bad", [np.nan, np.inf])
    def test_non_finite_input_is_refused(self, method_id, bad):
        X, _ = samples(5, 8)
        X[2, 7] = bad
        with pytest.raises(ValueError, match=r"NaN|infinity|inf|finite"):
            fitted(method_id).predict(X)
