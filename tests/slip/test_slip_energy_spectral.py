import numpy as np
import pytest

from slip.energy import Energy
from slip.spectral import Spectral, high_pass
from slip.windows import window_min, window_sum


def test_energy_of_a_ramp_is_its_slope():
    force = np.arange(200.0)[:, None] * np.array([0.01, -0.03])
    np.testing.assert_allclose(Energy(25).score(force)[26:], 0.02, rtol=1e-9)


def test_energy_is_the_plain_mean_and_homogeneous():
    force = np.random.default_rng(0).standard_normal((300, 16))
    plain = [np.abs(np.diff(force[t - 40 : t + 1], axis=0)).mean() for t in range(40, 300)]
    np.testing.assert_allclose(Energy(40).score(force)[40:], plain, rtol=1e-12)
    np.testing.assert_allclose(Energy(40).score(-3.0 * force), 3.0 * Energy(40).score(force), rtol=1e-12)


@pytest.mark.parametrize(("hz", "passes"), [(20.0, False), (60.0, False), (250.0, True), (400.0, True)])
def test_spectral_passes_the_high_band_and_stops_the_low_one(hz, passes):
    time = np.arange(2000) / 1000.0
    force = np.sin(2.0 * np.pi * hz * time)[:, None]
    squares = np.diff(force[:, 0]) ** 2
    share = Spectral(200, cutoff_hz=150.0).score(force)[-1] / squares[-200:].mean()
    assert (0.95 < share < 1.05) if passes else share < 1e-3


def test_a_steady_ramp_has_no_high_band():
    force = np.arange(500.0)[:, None] * np.ones((1, 16))
    assert Spectral(50).score(force)[200:].max() < 1e-28


def test_high_pass_is_linear_phase_with_stated_gains():
    taps = high_pass(150.0, 1000.0, 31)
    np.testing.assert_allclose(taps, taps[::-1], atol=1e-16)
    assert abs(taps.sum()) < 1e-15
    assert abs((taps * (-1.0) ** np.arange(31)).sum()) == pytest.approx(1.0)


@pytest.mark.parametrize("parameters", [{"taps": 30}, {"taps": 1}, {"cutoff_hz": 0.0}, {"cutoff_hz": 500.0}])
def test_filters_that_cannot_be_are_refused(parameters):
    with pytest.raises(ValueError, match="expected"):
        Spectral(**parameters)


@pytest.mark.parametrize("window", [1, 2, 3, 7, 50, 64, 100])
def test_sliding_sums_and_minima_are_those_of_each_window(window):
    values = np.random.default_rng(window).standard_normal((200, 3))
    views = np.lib.stride_tricks.sliding_window_view(values, window, axis=0)
    np.testing.assert_allclose(window_sum(values, window), views.sum(axis=-1), atol=1e-12)
    np.testing.assert_array_equal(window_min(values, window), views.min(axis=-1))
