"""The smallest distances are the first columns of a stable sort, ties and infinities included."""

import numpy as np
import pytest

from fusion.nearest import smallest


@pytest.mark.parametrize("count", [1, 2, 7, 40, 100])
@pytest.mark.parametrize("levels", [2, 5, 10**6])
def test_smallest_is_the_head_of_a_stable_sort(count, levels):
    rng = np.random.default_rng(count)
    distances = rng.integers(0, levels, (50, 40)).astype(float)
    distances[rng.random((50, 40)) < 0.1] = np.inf
    wanted = np.argsort(distances, axis=1, kind="stable")[:, :count]
    np.testing.assert_array_equal(smallest(distances, count), wanted)


def test_no_rows():
    assert smallest(np.empty((0, 5)), 3).shape == (0, 3)
