import numpy as np
import pytest
from slip_sequences import eventful, rest

import slip
from slip.calibrate import cfar
from slip.covariance import Covariance
from slip.earlier_slip import prior
from slip.energy import Energy
from slip.resample import rate_interval
from slip.rest_noise import measure_rest

SIZES = np.geomspace(1e-4, 1.0, 16)


def white(samples, seed, sizes=SIZES):
    return 3.0 + sizes * np.random.default_rng(seed).standard_normal((samples, len(sizes)))


def consistent(calibration, force):
    """Whether the measured rate and the asked one agree within both their 99 % intervals, on the log scale."""
    window = calibration.detector.settling
    alarms = calibration.detector.score(force)[window:] >= calibration.beta
    rate, low, high = rate_interval(alarms, window, level=0.99)
    asked = calibration.asked_rate
    own = np.log(calibration.high / asked)
    of_measurement = np.log(high / low) / 2.0
    return abs(np.log(rate / asked)) <= np.hypot(own, of_measurement)


@pytest.mark.parametrize("name", ["covariance", "covariance-taxel", "covariance-load-removed", "energy"])
def test_the_asked_rate_is_met_on_white_noise_of_any_size(name):
    found = cfar(slip.make_detector(name, window=20), white(20_000, 1), 0.02, level=0.99)
    assert found.low < 0.02 < found.high
    assert not found.coloured
    assert consistent(found, white(200_000, 2))


@pytest.mark.slow
@pytest.mark.parametrize("rate", [1e-2, 1e-3])
@pytest.mark.parametrize("name", slip.detector_names())
def test_the_asked_rate_is_met_over_a_million_samples(name, rate):
    found = cfar(slip.make_detector(name), white(60_000, 3), rate, level=0.99)
    assert consistent(found, white(1_000_000, 4))


@pytest.mark.slow
def test_the_rate_is_met_on_average_over_short_rest_segments():
    force = white(200_000, 100, np.ones(4))
    rates = []
    for seed in range(20):
        found = cfar(Covariance(10), white(1_500, seed, np.ones(4)), 0.01, seed=seed)
        rates.append((found.detector.score(force) >= found.beta).mean())
    spread = np.std(rates) / np.sqrt(len(rates))
    assert abs(np.mean(rates) - 0.01) < 4.0 * spread
    assert np.std(rates) > 3e-4  # the threshold's own error is there to be counted


def test_beta_does_not_depend_on_the_units_of_a_taxel():
    plain = cfar(Covariance(10), white(5_000, 5, np.ones(8)), 0.05)
    mixed = cfar(Covariance(10), 3.0 + SIZES[:8] * (white(5_000, 5, np.ones(8)) - 3.0), 0.05)
    assert mixed.beta == pytest.approx(plain.beta, rel=1e-9)


def test_beta_rises_as_the_rate_falls():
    noise = white(4_000, 6)
    betas = [cfar(Energy(10), noise, rate).beta for rate in (0.2, 0.05, 0.01)]
    assert betas == sorted(betas)
    assert betas[0] < betas[-1]


def test_coloured_noise_is_said_and_its_gap_printed():
    drive = np.random.default_rng(7).standard_normal((20_000, 16))
    slow = np.cumsum(drive, axis=0) * 1e-3
    found = cfar(Covariance(20), slow, 0.02)
    assert found.coloured
    assert "coloured or changes in size, gap" in str(found)
    assert found.gap == pytest.approx(found.rest_rate - 0.02)


def test_noise_that_changes_in_size_has_white_correlations_but_its_gap_is_printed():
    sizes = np.random.default_rng(7).choice([0.5, 1.0, 2.0], (40, 16)).repeat(500, axis=0)
    noise = 0.01 * np.random.default_rng(8).standard_normal((20_000, 16))
    assert not measure_rest(np.diff(sizes * noise, axis=0)).coloured
    found = cfar(Covariance(20), 1.0 + sizes * noise, 0.001)
    assert found.rest_low > found.high
    assert found.coloured
    assert "changes in size, gap" in str(found)
    assert not cfar(Covariance(20), 1.0 + noise, 0.001).coloured


def test_noise_shared_by_the_taxels_is_coloured_too():
    shared = np.random.default_rng(8).standard_normal((20_000, 1))
    own = np.random.default_rng(9).standard_normal((20_000, 16))
    assert measure_rest(np.diff(own + 0.3 * shared, axis=0)).coloured
    assert not measure_rest(np.diff(own, axis=0)).coloured


def test_a_dead_taxel_takes_the_others_scale_and_changes_nothing():
    noise = white(4_000, 10, np.ones(8))
    dead = noise.copy()
    dead[:, 3] = 1.5
    found = cfar(Energy(10), dead, 0.05)
    assert found.detector.scale[3] == pytest.approx(np.median(np.delete(found.detector.scale, 3)))
    alarms = found.detector.score(dead)[11:] >= found.beta
    assert 0.02 < alarms.mean() < 0.1


@pytest.mark.parametrize(
    ("noise", "rate", "says"),
    [
        (np.ones((5_000, 4)), 0.01, "never change"),
        (rest(200, 4), 0.01, "longer segment"),
        (rest(5_000, 4), 0.0, "between 0 and 0.5"),
        (rest(5_000, 4), 1e-9, "most_simulated"),
    ],
)
def test_what_cannot_be_calibrated_is_refused(noise, rate, says):
    with pytest.raises(ValueError, match=says):
        cfar(Covariance(20), noise, rate)


def test_the_same_seed_gives_the_same_beta():
    noise = white(3_000, 11)
    assert cfar(Energy(10), noise, 0.05, seed=4).beta == cfar(Energy(10), noise, 0.05, seed=4).beta


def test_prior_separates_a_slip_like_the_earlier_one_from_rest():
    earlier, later = eventful(3000, seed=0), eventful(3000, seed=1)
    found = prior(Covariance(50), earlier, (2000, 3000))
    again = found.detector.score(later) >= found.beta
    assert again[2100:].mean() > 0.6
    assert not again[:1000].any()
    assert found.rest_rate == 0.0


def test_prior_reaches_the_share_it_says():
    force = eventful(3000)
    found = prior(Energy(50), force, (2000, 3000), reached=0.75)
    during = Energy(50).score(force)[2000 + found.detector.settling :]
    assert (during >= found.beta).mean() == pytest.approx(0.75, abs=0.01)


@pytest.mark.parametrize("span", [(10, 10), (-1, 20), (5, 5000)])
def test_prior_refuses_a_slip_outside_the_trial(span):
    with pytest.raises(ValueError, match="within the"):
        prior(Energy(10), eventful(300), span)


def test_prior_refuses_a_slip_without_a_score():
    with pytest.raises(ValueError, match="score of 0"):
        prior(Energy(10), np.ones((300, 4)), (100, 200))


def test_a_rate_in_clusters_has_a_wider_interval_than_scattered_alarms():
    rng = np.random.default_rng(0)
    scattered = rng.uniform(size=100_000) < 0.02
    clustered = np.repeat(rng.uniform(size=500) < 0.02, 200)
    widths = [np.diff(rate_interval(flags, 50)[1:])[0] for flags in (scattered, clustered)]
    assert widths[1] > 3.0 * widths[0]


def test_no_alarm_seen_is_not_no_alarm_ever():
    rate, low, high = rate_interval(np.zeros(50_000, dtype=bool), 50)
    assert (rate, low) == (0.0, 0.0)
    assert 0.02 < high < 0.04  # about 3 / 100 blocks
