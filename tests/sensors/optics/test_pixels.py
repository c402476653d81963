"""Pixel loops against the formulas written as arrays, and the noise table against the normal distribution."""

from statistics import NormalDist

import numpy as np
import pytest

from sensors.optics.noise import normal_table, random_words
from sensors.optics.pixels import expose, shade

ROWS, COLUMNS = 24, 40


def scene() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(2)
    facet = rng.uniform(-40, 90, (3, 3, ROWS, COLUMNS)).astype(np.float32)
    slope_x, slope_y = rng.normal(0, 0.5, (2, ROWS, COLUMNS)).astype(np.float32)
    return facet, slope_x, slope_y, np.array([1.0, 0.7, 1.3], np.float32)


def test_a_facet_gets_light_times_its_unit_normal_and_none_from_behind():
    facet, slope_x, slope_y, gain = scene()
    normal = np.stack((-slope_x, -slope_y, np.ones_like(slope_x))).astype(float)
    normal /= np.linalg.norm(normal, axis=0)
    expected = np.einsum("ckyx,kyx->cyx", facet.astype(float), normal) * gain[:, None, None]
    assert (expected < -1).any()
    levels = shade(facet, slope_x, slope_y, gain)
    assert levels.dtype == np.float32
    assert levels == pytest.approx(np.maximum(expected, 0), abs=1e-4)


def test_levels_are_rounded_and_cut_where_there_is_no_noise():
    levels = np.random.default_rng(0).uniform(0, 400, (3, ROWS, COLUMNS)).astype(np.float32)
    frame = expose(levels, random_words(None, levels.size), normal_table(), 0.0, 0.0)
    assert np.array_equal(frame, np.minimum(np.rint(levels), 255).transpose(1, 2, 0))
    assert levels.max() > 256


def test_every_value_takes_sixteen_bits_of_its_own():
    size = 3 * ROWS * COLUMNS
    words = random_words(np.random.default_rng(1), size)
    levels = np.full((3, ROWS, COLUMNS), 100, np.float32)
    frame = expose(levels, words, normal_table(), 9.0, 0.0)
    bits = np.stack([words >> np.uint64(16 * part) & np.uint64(0xFFFF) for part in range(4)], axis=-1).ravel()[:size]
    noise = normal_table()[bits].reshape(ROWS, 3, COLUMNS).transpose(0, 2, 1)
    assert np.array_equal(frame, np.rint(100 + 3 * noise))


def test_compiled_loops_give_the_values_of_the_same_python():
    facet, slope_x, slope_y, gain = scene()
    levels = shade(facet, slope_x, slope_y, gain)
    assert np.array_equal(levels, shade.__wrapped__(facet, slope_x, slope_y, gain))
    noise = (random_words(np.random.default_rng(4), levels.size), normal_table(), 1.0, 0.02)
    assert np.array_equal(expose(levels, *noise), expose.__wrapped__(levels, *noise))


def test_the_table_holds_a_normal_variable_in_equal_shares():
    table = normal_table().astype(float)
    share = np.array([NormalDist().cdf(value) for value in table[::257]])
    # each value lies in its own interval of the distribution
    assert np.array_equal(np.floor(share * len(table)), np.arange(len(table))[::257])
    assert table.mean() == 0
    assert table.var() == pytest.approx(1, abs=2e-6)
    assert (table**4).mean() == pytest.approx(3, abs=2e-4)
    for level in (1, 2, 3, 4):
        assert (table > level).mean() == pytest.approx(1 - NormalDist().cdf(level), abs=1 / len(table))


def test_noise_is_independent_between_pixels_and_colours():
    levels = np.full((3, 256, 256), 128, np.float32)
    words = random_words(np.random.default_rng(6), levels.size)
    error = expose(levels, words, normal_table(), 100.0, 0.0) - 128.0
    error /= np.sqrt(100 + 1 / 12)
    bound = 4.5 / np.sqrt(levels.size)  # of a mean of products of independent unit variables
    assert abs(error.mean()) < bound
    assert error.var() == pytest.approx(1, abs=1.5 * bound)
    assert (error**4).mean() == pytest.approx(3, abs=10 * bound)
    for axis in range(3):
        for step in (1, 2):
            ahead = np.take(error, range(step, error.shape[axis]), axis)
            behind = np.take(error, range(error.shape[axis] - step), axis)
            assert abs((ahead * behind).mean()) < 2 * bound
