"""The shapes that are pressed for training: fixed by their number, varied, twins alike but not the same."""

import numpy as np
import pytest

from vtbench.training.shapes import shape

CENTRE = (0.0, 0.0, 0.0)


def seen(number, pose=CENTRE, n=48):
    return shape(number).placed(n, 0.08, pose)


def test_a_number_is_the_same_shape_everywhere_and_no_other():
    fields = np.stack([seen(k) for k in range(40)])
    np.testing.assert_array_equal(fields[7], seen(7))
    assert np.isfinite(fields).all()
    assert (fields >= 0).all()
    assert (fields.max(axis=(1, 2)) > 2e-3).all()
    distances = np.sqrt(((fields[:, None] - fields[None]) ** 2).mean(axis=(2, 3))) + np.eye(40)
    assert distances.min() > 5e-5


def test_twins_are_nearer_to_each_other_than_shapes_are():
    fields = np.stack([seen(k) for k in range(40)]).reshape(20, 2, -1)
    between_twins = np.sqrt(((fields[:, 0] - fields[:, 1]) ** 2).mean(axis=1))
    to_others = np.sqrt(((fields[:, 0] - np.roll(fields[:, 0], 1, axis=0)) ** 2).mean(axis=1))
    assert np.median(between_twins) < 0.7 * np.median(to_others)


def test_a_shape_moves_and_turns_with_its_pose():
    number = 10
    still = seen(number, n=80)
    moved = seen(number, (5.0, -3.0, 0.0), n=80)
    np.testing.assert_allclose(np.roll(still, (-3, 5), axis=(0, 1)), moved, atol=1e-6)
    turned = seen(number, (0.0, 0.0, 90.0), n=80)
    np.testing.assert_allclose(np.rot90(still, -1), turned, atol=1e-4)


def test_a_number_below_zero_is_refused():
    with pytest.raises(ValueError, match="shape number must be >= 0, got -1"):
        shape(-1)
