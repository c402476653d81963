"""Reductions: nested ones equal fresh ones, and all is learnt from the training part."""

import numpy as np
import pytest

from tests.vtbench.run import small
from vtbench.run import reduce
from vtbench.run.reduce import Reducer
from vtbench.tasks.base import Block

TRAIN, TEST = np.arange(40), np.arange(40, 60)


def by_hand(train, test, size):
    """Standardise, principal components by eigenvectors of the covariance, mean squared norm 1."""
    train, test = train.astype(float), test.astype(float)
    mean, sd = train.mean(0), train.std(0)
    a, b = (train - mean) / sd, (test - mean) / sd
    if size is not None:
        _, vectors = np.linalg.eigh(a.T @ a)
        a, b = a @ vectors[:, ::-1][:, :size], b @ vectors[:, ::-1][:, :size]
    scale = np.sqrt(np.mean((a**2).sum(1)))
    return a / scale, b / scale


def same_up_to_signs(left, right):
    """Distances and angles, all that a classifier sees, agree."""
    np.testing.assert_allclose(left.train @ left.train.T, right[0] @ right[0].T, atol=1e-5)
    np.testing.assert_allclose(left.test @ left.train.T, right[1] @ right[0].T, atol=1e-5)


@pytest.mark.parametrize("size", [2, 4, 8, 11])
def test_cutting_a_large_reduction_equals_a_fresh_one_of_that_size(size):
    blocks, _, _ = small.samples()
    nested = Reducer(blocks, "scaled").at(Block("image", components=(2, 4, 8, 11)), size, TRAIN, TEST)
    fresh = Reducer(blocks, "scaled").at(Block("image", components=(size,)), size, TRAIN, TEST)
    assert nested.train.shape == (40, size)
    np.testing.assert_allclose(np.abs(nested.train), np.abs(fresh.train), atol=1e-9)
    np.testing.assert_allclose(np.abs(nested.test), np.abs(fresh.test), atol=1e-9)
    same_up_to_signs(nested, by_hand(blocks["image"][TRAIN], blocks["image"][TEST], size))


def test_without_sizes_a_block_is_standardised_and_scaled_only():
    blocks, _, _ = small.samples()
    got = Reducer(blocks, "scaled").at(Block("force"), None, TRAIN, TEST)
    train, test = by_hand(blocks["force"][TRAIN], blocks["force"][TEST], None)
    np.testing.assert_allclose(got.train, train, atol=1e-6)
    np.testing.assert_allclose(got.test, test, atol=1e-6)


def test_leading_columns_are_cut_before_they_are_scaled():
    blocks, _, _ = small.samples()
    got = Reducer(blocks, "scaled").at(Block("image", leading=(3, 12)), 3, TRAIN, TEST)
    train, test = by_hand(blocks["image"][TRAIN, :3], blocks["image"][TEST, :3], None)
    np.testing.assert_allclose(got.train, train, atol=1e-6)
    np.testing.assert_allclose(got.test, test, atol=1e-6)


def test_a_method_that_brings_its_own_gets_columns_as_they_are():
    blocks, _, _ = small.samples()
    for block, size in ((Block("image", leading=(3, 12)), 3), (Block("image"), None)):
        got = Reducer(blocks, "none").at(block, size, TRAIN, TEST)
        np.testing.assert_array_equal(got.train, blocks["image"][TRAIN, :size])
        np.testing.assert_array_equal(got.test, blocks["image"][TEST, :size])


@pytest.mark.parametrize("block", [Block("image", components=(4, 8)), Block("image", leading=(4, 8)), Block("image")])
def test_the_test_part_moves_nothing_in_training(block):
    blocks, _, _ = small.samples()
    other = {name: np.where(np.arange(60)[:, None] < 50, values, 1e4) for name, values in blocks.items()}
    size = block.sizes[0] if block.sizes else None
    one, two = (Reducer(given, "scaled").at(block, size, TRAIN, TEST) for given in (blocks, other))
    np.testing.assert_array_equal(one.train, two.train)
    np.testing.assert_allclose(one.test[:10], two.test[:10], atol=1e-9)
    assert np.mean((one.train**2).sum(1)) == pytest.approx(1.0)


def test_a_size_beyond_the_samples_is_what_they_allow():
    blocks, _, _ = small.samples()
    few = np.arange(5)
    assert Reducer(blocks, "scaled").at(Block("image", components=(4, 8)), 8, few, TEST).train.shape == (5, 5)


def test_what_is_remembered_stays_bounded_and_changes_no_result(monkeypatch):
    blocks, _, _ = small.samples()
    block = Block("image", components=(8,))
    fits = [np.setdiff1d(np.arange(60), np.arange(i, i + 10)) for i in range(0, 50, 5)]
    whole = Reducer(blocks, "scaled")
    expected = [whole.at(block, 8, train, TEST).train for train in fits]
    calls = []
    plain = reduce._scaled
    monkeypatch.setattr(reduce, "_scaled", lambda *given: calls.append(1) or plain(*given))
    for train, values in zip(fits, expected, strict=True):
        np.testing.assert_array_equal(whole.at(block, 8, train, TEST).train, values)
    assert not calls  # remembered
    monkeypatch.setattr(reduce, "KEPT_BYTES", 3 * expected[0].nbytes)
    tight = Reducer(blocks, "scaled")
    for _ in range(2):
        for train, values in zip(fits, expected, strict=True):
            np.testing.assert_array_equal(tight.at(block, 8, train, TEST).train, values)
            assert sum(kept.nbytes for kept in tight._kept.values()) <= reduce.KEPT_BYTES
    assert len(calls) == 2 * len(fits)


def test_a_constant_block_stays_finite():
    flat = {"image": np.ones((60, 4), np.float32)}
    got = Reducer(flat, "scaled").at(Block("image", components=(2, 3)), 2, TRAIN, TEST)
    assert not got.train.any()
    assert not got.test.any()
