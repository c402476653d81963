"""Laws of PCA by modality."""

import numpy as np
import pytest
from sklearn.decomposition import PCA
from sklearn.preprocessing import StandardScaler

from fusion import JKSC
from fusion.features import ModalityPCA
from fusion.features.pca import DOUBTFUL, _principal_axes

GROUPS = {"image": slice(0, 20), "force": slice(20, 26)}
RNG = np.random.default_rng(0)
X = RNG.normal(size=(50, 26)) @ RNG.normal(size=(26, 26)) * np.where(np.arange(26) < 20, 1e3, 1e-3)
NEW = RNG.normal(size=(7, 26)) @ RNG.normal(size=(26, 26))


def energy(block):
    return np.mean(np.sum(block**2, axis=1))


def test_each_group_is_standardised_reduced_and_scaled_to_mean_squared_norm_one():
    model = ModalityPCA(GROUPS, {"image": 5}).fit(X)
    assert model.output_groups_ == {"image": slice(0, 5), "force": slice(5, 11)}
    out = model.transform(X)
    scaler = StandardScaler().fit(X[:, :20])
    pca = PCA(5, svd_solver="full").fit(scaler.transform(X[:, :20]))
    expected = pca.transform(scaler.transform(X[:, :20]))
    np.testing.assert_allclose(out[:, :5], expected / np.sqrt(energy(expected)), atol=1e-10)
    for columns in model.output_groups_.values():
        assert energy(out[:, columns]) == pytest.approx(1.0)


def rows_with(singular_values, n, d, seed=1):
    """Centred rows (n, d) of given singular values."""
    rng = np.random.default_rng(seed)
    rank = len(singular_values)
    left = np.linalg.qr(np.column_stack([np.ones(n), rng.normal(size=(n, rank))]))[0][:, 1:]
    return left * singular_values @ np.linalg.qr(rng.normal(size=(d, rank)))[0].T


@pytest.mark.parametrize(("n", "d"), [(30, 700), (400, 25), (60, 60)])
@pytest.mark.parametrize(
    "values",
    [np.geomspace(1e3, 1e2, 20), np.geomspace(1, 3 * DOUBTFUL, 20), np.geomspace(1e-3, 1e-12, 20)],
    ids=["usual", "above the limit", "below it"],
)
def test_axes_are_those_of_the_decomposed_rows(n, d, values):
    rows = rows_with(values, n, d)
    axes, expected = _principal_axes(rows, 12), PCA(12, svd_solver="full").fit(rows).components_
    np.testing.assert_allclose(axes, expected, atol=1e-11 if values[11] > DOUBTFUL * values[0] else 1e-8)
    np.testing.assert_allclose(axes @ axes.T, np.eye(12), atol=1e-13)


@pytest.mark.parametrize(("n", "d"), [(30, 700), (400, 25)])
def test_equal_singular_values_span_the_same_space(n, d):
    rows = rows_with(np.array([3, 2, 2, 2 - 1e-13, 1, 1 - 1e-9, 0.5, 0.1, 0.1, 0.1]), n, d)
    axes, expected = _principal_axes(rows, 6), PCA(6, svd_solver="full").fit(rows).components_
    np.testing.assert_allclose(axes.T @ axes, expected.T @ expected, atol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(rows @ axes.T, axis=0), [3, 2, 2, 2, 1, 1], rtol=1e-8)


def test_single_precision_and_constant_columns_reduce_as_decomposed_rows_do():
    many = (RNG.normal(size=(40, 6)) @ RNG.normal(size=(6, 900)) + 0.1 * RNG.normal(size=(40, 900)) + 50).astype("f4")
    many[:, ::7] = 3.3
    varied = np.delete(many, np.s_[::7], axis=1).astype(float)
    pca = PCA(8, svd_solver="full").fit(StandardScaler().fit_transform(varied))
    expected = pca.transform(StandardScaler().fit_transform(varied))
    out = ModalityPCA(n_components=8).fit(many).transform(many)
    np.testing.assert_allclose(np.abs(out), np.abs(expected) / np.sqrt(energy(expected)), atol=1e-11)


def test_weights_multiply_the_scaled_groups():
    plain = ModalityPCA(GROUPS, 4).fit(X).transform(NEW)
    weighted = ModalityPCA(GROUPS, 4, {"force": 0.5}).fit(X).transform(NEW)
    np.testing.assert_array_equal(weighted[:, :4], plain[:, :4])
    np.testing.assert_allclose(weighted[:, 4:], 0.5 * plain[:, 4:])


def test_all_components_keep_the_distances():
    kept, turned = (ModalityPCA(GROUPS, n).fit(X).transform(NEW) for n in (None, 100))
    assert turned.shape == kept.shape
    distance = [np.linalg.norm(z[:, None] - z[None], axis=2) for z in (kept, turned)]
    np.testing.assert_allclose(distance[0], distance[1], rtol=1e-9)


def test_the_units_of_a_group_play_no_part():
    a = ModalityPCA(GROUPS, 4).fit(X).transform(NEW)
    unit = np.where(np.arange(26) < 20, 1e-6, 1e4)
    b = ModalityPCA(GROUPS, 4).fit(X * unit).transform(NEW * unit)
    np.testing.assert_allclose(a, b, rtol=1e-7, atol=1e-9)


def test_later_samples_do_not_move_what_was_learnt():
    model = ModalityPCA(GROUPS, 4).fit(X)
    np.testing.assert_allclose(model.transform(NEW)[:3], model.transform(NEW[:3]), rtol=1e-12)


def test_a_constant_group_is_zero_and_finite():
    flat = X.copy()
    flat[:, 20:] = 0.1
    model = ModalityPCA(GROUPS, 3).fit(flat)
    np.testing.assert_array_equal(model.transform(NEW)[:, 3:], 0)


def test_more_components_than_a_group_can_give_are_cut():
    assert ModalityPCA(GROUPS, 10).fit(X).output_groups_ == {"image": slice(0, 10), "force": slice(10, 16)}
    assert ModalityPCA(GROUPS, 10).fit(X[:4]).output_groups_ == {"image": slice(0, 4), "force": slice(4, 8)}


def test_names_and_groups_fit_the_output_and_joint_coding():
    model = ModalityPCA(GROUPS, {"image": 2, "force": 1}).fit(X)
    assert model.get_feature_names_out().tolist() == ["image0", "image1", "force0"]
    y = np.arange(50) % 3
    assert JKSC(model.output_groups_).fit(model.transform(X), y).predict(model.transform(NEW)).shape == (7,)


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"groups": GROUPS, "n_components": {"sound": 2}}, "n_components name sound; the groups are image, force"),
        ({"groups": GROUPS, "weights": {"sound": 2}}, "weights name sound"),
        ({"n_components": 0}, "n_components of group 'all'"),
        ({"weights": {"all": -1.0}}, "weight of group 'all'"),
        ({"groups": {"image": slice(0, 27)}}, "do not fit the 26 columns"),
    ],
)
def test_wrong_settings_are_named(params, message):
    with pytest.raises(ValueError, match=message):
        ModalityPCA(**params).fit(X)
