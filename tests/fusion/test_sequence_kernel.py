"""Laws of the global alignment kernel and of kernels given as functions."""

import sys

import numpy as np
import pytest

from fusion import JKSC, KSC, GlobalAlignment
from fusion.kernels import linear_kernel, rbf_kernel


def presses(seed=0, per_class=6, steps=14, channels=3):
    """Force histories of three shapes, each at its own pace: rows of steps x channels, labels."""
    rng = np.random.default_rng(seed)
    y = np.arange(3 * per_class) % 3
    pace = rng.uniform(0.7, 1.4, size=len(y))
    time = np.linspace(0, 1, steps)[None, :] ** pace[:, None]
    shape = np.stack([np.sin(np.pi * time * (label + 1)) for label in range(3)])[y, np.arange(len(y))]
    gains = rng.uniform(0.9, 1.1, size=(len(y), 1, channels))
    return (shape[:, :, None] * gains).reshape(len(y), -1), y


@pytest.mark.slow  # tslearn takes seconds to load
def test_is_symmetric_positive_definite_and_one_on_the_diagonal():
    pytest.importorskip("tslearn")
    X, _ = presses()
    K = GlobalAlignment(3, sigma=2.0)(X, X)
    np.testing.assert_allclose(K, K.T, atol=1e-12)
    np.testing.assert_allclose(np.diagonal(K), 1.0, rtol=1e-12)
    assert np.linalg.eigvalsh(K).min() > -1e-12
    assert 0.01 < K[~np.eye(len(K), dtype=bool)].mean() < 0.99


@pytest.mark.slow  # tslearn takes seconds to load
def test_classifies_sequences_of_another_pace_as_a_function_and_precomputed():
    pytest.importorskip("tslearn")
    X, y = presses(0)
    queries, truth = presses(1)
    kernel = GlobalAlignment(3, sigma=2.0)
    labels = KSC(kernel, normalize_kernel=False).fit(X, y).predict(queries)
    assert np.mean(labels == truth) > 0.9
    precomputed = KSC("precomputed", normalize_kernel=False).fit(kernel(X, X), y)
    np.testing.assert_array_equal(precomputed.predict(kernel(queries, X)), labels)


def test_says_which_extra_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "tslearn.metrics", None)
    with pytest.raises(ImportError, match=r"pip install 'vtbench\[sequence\]'"):
        GlobalAlignment(2, 1.0)(np.ones((1, 4)), np.ones((1, 4)))


@pytest.mark.parametrize(("channels", "sigma"), [(0, 1.0), (2, 0.0), (2, np.inf), (2, np.nan)])
def test_settings_without_meaning_are_refused(channels, sigma):
    with pytest.raises(ValueError, match="GlobalAlignment needs"):
        GlobalAlignment(channels, sigma)


@pytest.mark.slow  # tslearn takes seconds to load
def test_rows_that_hold_no_whole_samples_are_refused():
    pytest.importorskip("tslearn")
    with pytest.raises(ValueError, match="whole samples of 3 channels"):
        GlobalAlignment(3, 1.0)(np.ones((2, 7)), np.ones((2, 7)))


def test_a_kernel_function_gives_the_labels_of_the_kernel_by_name():
    rng = np.random.default_rng(2)
    X, y, queries = rng.normal(size=(40, 6)), np.arange(40) % 4, rng.normal(size=(25, 6))
    expected = KSC(gamma=0.1).fit(X, y).predict(queries)
    np.testing.assert_array_equal(KSC(lambda a, b: rbf_kernel(a, b, 0.1)).fit(X, y).predict(queries), expected)
    modalities = {"image": slice(0, 4), "force": slice(4, 6)}
    by_name = JKSC(modalities, kernel="linear").fit(X, y).decision_function(queries)
    by_function = JKSC(modalities, kernel=linear_kernel).fit(X, y).decision_function(queries)
    np.testing.assert_allclose(by_function, by_name, atol=1e-12)


@pytest.mark.parametrize(
    ("kernel", "message"),
    [
        (lambda a, b: np.ones(len(a)), "must return shape"),
        (lambda a, b: np.full((len(a), len(b)), np.nan), "not finite"),
    ],
)
def test_a_kernel_function_that_returns_nonsense_is_named(kernel, message):
    with pytest.raises(ValueError, match=message):
        KSC(kernel).fit(np.eye(4), [0, 1, 0, 1])
