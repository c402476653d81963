import tracemalloc

import numpy as np
import pytest
from slip_sequences import disagreement, eventful, rest, stream

from slip.covariance import Covariance, covariance_norm, plain_norm, taxel_scores
from slip.differences import relate_to_load_change, remove_load, remove_mean
from slip.gram_narrow import narrow_scores
from slip.gram_wide import wide_scores


@pytest.mark.parametrize(("window", "samples"), [(2, 1), (2, 700), (3, 40), (50, 30), (50, 2000), (256, 600)])
def test_batch_is_the_papers_formula_window_by_window(window, samples):
    force = eventful(samples, seed=window)
    np.testing.assert_allclose(covariance_norm(force, window), plain_norm(force, window), rtol=1e-12, atol=1e-300)


@pytest.mark.parametrize("window", [2, 7, 50, 300])
def test_short_and_long_window_forms_agree(window):
    differences = np.diff(eventful(4 * window + 900), axis=0)
    np.testing.assert_allclose(
        narrow_scores(differences, window), wide_scores(differences, window), rtol=1e-12, atol=1e-300
    )


def test_taxel_side_is_the_largest_row_of_chi_t_chi():
    force, window = eventful(400), 20
    chi = np.vstack([np.zeros((window, 16)), np.diff(force, axis=0)])
    expected = [
        np.linalg.norm(gram - np.diag(np.diag(gram)), np.inf)
        for gram in (chi[t : t + window].T @ chi[t : t + window] for t in range(1, len(chi) - window + 1))
    ]
    np.testing.assert_allclose(covariance_norm(force, window, side="taxel")[1:], expected, rtol=1e-10)


@pytest.mark.parametrize("side", ["time", "taxel"])
def test_score_grows_with_the_square_of_force_and_ignores_offsets_sign_and_taxel_order(side):
    force = eventful(600)
    score = covariance_norm(force, 30, side)
    order = np.random.default_rng(1).permutation(16)
    np.testing.assert_allclose(covariance_norm(1024.0 * force, 30, side), 1024.0**2 * score, rtol=1e-12)
    np.testing.assert_allclose(covariance_norm(-force, 30, side), score, rtol=1e-12)
    np.testing.assert_allclose(covariance_norm(force[:, order], 30, side), score, rtol=1e-10, atol=1e-18)
    np.testing.assert_allclose(covariance_norm(force + 8.0, 30, side), score, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("side", ["time", "taxel"])
def test_a_spike_that_left_the_window_leaves_nothing(side):
    window, spiked, clean = 50, eventful(900, spike_at=300), eventful(900)
    gone = slice(300 + window + 1, None)
    np.testing.assert_allclose(
        covariance_norm(spiked, window, side)[gone], covariance_norm(clean, window, side)[gone], rtol=1e-12
    )


@pytest.mark.parametrize("side", ["time", "taxel"])
def test_dead_and_saturated_channels_add_nothing(side):
    force = eventful(400, taxels=14)
    padded = np.hstack([force, np.zeros((400, 1)), np.full((400, 1), 50.0)])
    np.testing.assert_allclose(covariance_norm(padded, 25, side), covariance_norm(force, 25, side), rtol=1e-12)


def test_a_single_taxel_has_no_taxel_side_but_a_time_side():
    force = eventful(200, taxels=1)
    assert (covariance_norm(force, 10, side="taxel") == 0.0).all()
    np.testing.assert_allclose(covariance_norm(force, 10), plain_norm(force, 10), rtol=1e-12)


def test_a_load_that_keeps_its_pattern_is_invisible_once_the_load_is_removed():
    time = np.linspace(0.0, 1.0, 400)
    force = (1.0 + np.sin(9.0 * time) ** 2)[:, None] * np.random.default_rng(0).uniform(0.1, 1.0, 16)
    kept = Covariance(30).score(force).max()
    removed = Covariance(30, common_mode="load").score(force).max()
    assert kept > 1e-4
    assert removed < 1e-20 * kept


def test_mean_removal_takes_what_all_taxels_feel_and_only_that():
    change = np.random.default_rng(0).standard_normal((50, 16))
    uniform = np.random.default_rng(1).standard_normal((50, 1))
    np.testing.assert_allclose(remove_mean(change + uniform), remove_mean(change), atol=1e-14)
    np.testing.assert_allclose(remove_mean(remove_mean(change)), remove_mean(change), atol=1e-14)


def test_load_removal_leaves_a_difference_across_the_load():
    load, change = np.random.default_rng(0).standard_normal((2, 50, 16))
    left = remove_load(change, load)
    np.testing.assert_allclose((left * load).sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_array_equal(remove_load(change, np.zeros_like(load)), change)


def test_ratio_bounds_a_coherent_load_change_but_not_a_redistribution():
    pattern = np.random.default_rng(0).uniform(0.1, 1.0, 16)
    assert (np.abs(relate_to_load_change(1e6 * pattern[None])).sum(axis=1) < 1.0).all()
    exchange = np.zeros((1, 16))
    exchange[0, :2] = 3.0, -3.0
    assert np.abs(relate_to_load_change(exchange)).sum() > 20.0


def test_variants_see_slip_through_a_coherent_transient_better_than_the_plain_detector():
    samples, window = 3000, 50
    pattern = np.random.default_rng(3).uniform(0.2, 1.0, 16)
    load = 1.0 + 2.0 * (np.arange(samples) > 1000) * (np.arange(samples) < 1200) * np.sin(
        np.pi * (np.arange(samples) - 1000) / 200
    )
    force = load[:, None] * pattern + 1e-3 * np.random.default_rng(4).standard_normal((samples, 16))
    force[2000:] += 6e-3 * np.random.default_rng(5).standard_normal((1000, 16))
    for mode, wins in (("keep", False), ("load", True)):
        score = Covariance(window, common_mode=mode).score(force)
        assert (np.median(score[2100:]) > score[1000:1200].max()) == wins, mode


@pytest.mark.parametrize("side", ["time", "taxel"])
def test_a_window_of_ten_thousand_streams_as_it_batches(side):
    window, force = 10_000, rest(1500, taxels=4)
    streamed = stream(Covariance(window, side=side), force)
    assert disagreement(streamed, covariance_norm(force, window, side), window) <= 1e-12


@pytest.mark.parametrize("side", ["time", "taxel"])
def test_stream_memory_is_of_order_window_times_taxels(side):
    window, taxels = 10_000, 4
    detector = Covariance(window, side=side)
    samples = rest(3, taxels)
    tracemalloc.start()
    for sample in samples:
        detector.update(sample)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 4 * 8 * window * taxels


def test_batch_memory_does_not_hold_the_gram_matrix_of_a_long_window():
    window, differences = 4_000, rest(5_000, 16)
    tracemalloc.start()
    wide_scores(differences, window)
    taxel_scores(differences, window)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 8 * window * window / 8


@pytest.mark.slow
@pytest.mark.parametrize("side", ["time", "taxel"])
def test_ten_minutes_at_1_khz_with_a_spike_stream_as_they_batch(side):
    force = eventful(600_000, spike_at=250_000)
    assert disagreement(stream(Covariance(50, side=side), force), covariance_norm(force, 50, side), 50) <= 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("side", ["time", "taxel"])
def test_windows_of_ten_thousand_with_a_spike_that_leaves(side):
    window, force = 10_000, eventful(35_000, spike_at=1_000)
    streamed = stream(Covariance(window, side=side), force)
    assert disagreement(streamed, covariance_norm(force, window, side), window) <= 1e-12
