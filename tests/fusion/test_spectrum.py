"""Laws of the spectra."""

import numpy as np
import pytest

from fusion.features import FourierBasis, ResampledSpectrum
from fusion.features.spectrum import z_score


def recordings(lengths=(40, 97, 64), channels=3, seed=0):
    rng = np.random.default_rng(seed)
    return [rng.normal(size=(length, channels)).cumsum(axis=0) for length in lengths]


@pytest.mark.parametrize("model", [FourierBasis(6), FourierBasis(6, period=30.0), ResampledSpectrum(12)], ids=str)
def test_size_does_not_depend_on_length_and_rows_not_on_each_other(model):
    series = recordings()
    out = model.fit_transform(series)
    assert out.shape == (3, 36)
    for row, one in zip(out, series, strict=True):
        np.testing.assert_array_equal(model.transform([one])[0], row)


@pytest.mark.parametrize("model", [FourierBasis(6), ResampledSpectrum(12)], ids=str)
def test_gain_and_offset_of_a_taxel_change_nothing(model):
    series = recordings()
    moved = [x * [10.0, 0.1, 3.0] + [5.0, -100.0, 0.0] for x in series]
    np.testing.assert_allclose(model.fit_transform(moved), model.fit_transform(series), atol=1e-9)


@pytest.mark.parametrize("period", [None, 25.0])
def test_fourier_coefficients_solve_the_least_squares_problem(period):
    (series,) = recordings((60,))
    out = FourierBasis(4, period=period).fit_transform([series]).reshape(4, 2, 3)
    t = np.arange(60)
    w = 2 * np.pi / (period or 60)
    columns = [np.ones(60)] + [wave(j * w * t) for j in range(1, 5) for wave in (np.sin, np.cos)]
    expected = np.linalg.lstsq(np.stack(columns, axis=1), z_score(series), rcond=None)[0][1:]
    np.testing.assert_allclose(out.reshape(8, 3), expected, atol=1e-12)


def test_own_length_as_period_is_the_discrete_fourier_transform():
    (series,) = recordings((81,))
    out = FourierBasis(10).fit_transform([series]).reshape(10, 2, 3)
    transform = 2 / 81 * np.fft.rfft(z_score(series), axis=0)[1:11]
    np.testing.assert_allclose(out[:, 0], -transform.imag, atol=1e-12)
    np.testing.assert_allclose(out[:, 1], transform.real, atol=1e-12)


def test_a_sine_of_known_period_stands_in_its_harmonic_whatever_the_length():
    for length in (200, 333, 471):
        t = np.arange(length)
        out = FourierBasis(5, period=40.0).fit_transform([np.sin(3 * 2 * np.pi / 40 * t)[:, None]]).reshape(5, 2)
        assert np.hypot(*out[2]) == pytest.approx(np.sqrt(2), rel=1e-2)
        assert np.abs(np.delete(out, 2, axis=0)).max() < 0.05


def test_harmonics_beyond_a_short_recording_are_zero():
    out = FourierBasis(10).fit_transform([recordings((7,))[0]]).reshape(10, 2, 3)
    assert np.any(out[2] != 0)
    np.testing.assert_array_equal(out[3:], 0)


def test_harmonics_that_cannot_be_told_apart_are_an_error():
    with pytest.raises(ValueError, match="30 samples cannot tell 8 harmonics of period 1e"):
        FourierBasis(8, period=1e6).fit_transform([np.random.default_rng(0).normal(size=(30, 2))])


def test_resampled_amplitudes_equal_the_transform_where_the_grids_meet():
    (series,) = recordings((64,))
    out = ResampledSpectrum(33).fit_transform([series]).reshape(33, 3)
    np.testing.assert_allclose(out, 2 / 64 * np.abs(np.fft.rfft(z_score(series), axis=0)), atol=1e-12)


def test_a_stack_equals_a_list_and_a_matrix_is_one_channel_each():
    stack = np.stack(recordings((50, 50)))
    for model in (FourierBasis(4), ResampledSpectrum(9)):
        np.testing.assert_array_equal(model.fit_transform(stack), model.fit_transform(list(stack)))
        matrix = stack[:, :, 0]
        np.testing.assert_array_equal(model.fit_transform(matrix), model.fit_transform(list(matrix[:, :, None])))


def test_dead_taxels_give_zeros():
    (series,) = recordings((50,))
    series[:, 1] = 0.1
    for model in (FourierBasis(4), ResampledSpectrum(9)):
        out = model.fit_transform([series]).reshape(-1, 3)
        np.testing.assert_array_equal(out[:, 1], 0)
        assert np.isfinite(out).all()


def test_recordings_that_do_not_fit_are_named():
    model = FourierBasis(3).fit(recordings())
    with pytest.raises(ValueError, match=r"recording 1 must be an array \(samples, 3 channels\)"):
        model.transform([np.zeros((20, 3)), np.zeros((20, 4))])
    with pytest.raises(ValueError, match="recording 0 holds values that are not finite"):
        model.transform([np.full((20, 3), np.nan)])
    with pytest.raises(ValueError, match="n_harmonics must be"):
        FourierBasis(0).fit(recordings())
    with pytest.raises(ValueError, match="period must be"):
        FourierBasis(period=-1.0).fit(recordings())
    with pytest.raises(ValueError, match="n_bins must be"):
        ResampledSpectrum(2.5).fit(recordings())
