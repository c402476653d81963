"""Spectra in a graph are those of `FourierBasis`, for recordings of any length."""

from functools import cache

import numpy as np
import onnxruntime
import pytest

from fusion.features import FourierBasis
from fusion.onnx.builder import Graph
from fusion.onnx.ends import float_input
from fusion.onnx.series import step_means
from fusion.onnx.spectrum import amplitudes, fourier_coefficients

HARMONICS, CHANNELS = 8, 3


@cache
def session(amplitude):
    graph = Graph()
    series, _ = float_input(graph, "force_series", ["N", "T", CHANNELS])
    made = fourier_coefficients(graph, series, HARMONICS)
    made = amplitudes(graph, made, HARMONICS, CHANNELS) if amplitude else made
    width = HARMONICS * CHANNELS * (1 if amplitude else 2)
    graph.output("spectrum", graph.op("Cast", made, to=1), ["N", width])
    return onnxruntime.InferenceSession(graph.model("spectrum").SerializeToString())


def spectrum(series, amplitude=False):
    return session(amplitude).run(None, {"force_series": np.asarray(series, np.float32)})[0]


@pytest.mark.parametrize("length", [1, 2, 3, 16, 17, 18, 141, 2117])
def test_coefficients_are_the_least_squares_ones_whatever_the_length(length):
    rng = np.random.default_rng(length)
    series = np.round(1000 + 300 * rng.standard_normal((2, length, CHANNELS))).astype(np.float32)
    series[1, :, 2] = 512.0
    expected = FourierBasis(HARMONICS).fit_transform(series.astype(np.float64))
    np.testing.assert_allclose(spectrum(series), expected, atol=2e-7)
    pairs = expected.reshape(2, HARMONICS, 2, CHANNELS)
    np.testing.assert_allclose(
        spectrum(series, amplitude=True), np.hypot(pairs[:, :, 0], pairs[:, :, 1]).reshape(2, -1), atol=3e-7
    )


def test_a_sine_of_whole_periods_stands_in_its_own_harmonic_alone():
    t = np.arange(60)
    series = np.stack([np.sin(2 * np.pi * (k + 1) * t / 60) for k in range(CHANNELS)], axis=1)[None]
    found = spectrum(series, amplitude=True).reshape(HARMONICS, CHANNELS)
    expected = np.zeros((HARMONICS, CHANNELS))
    expected[range(CHANNELS), range(CHANNELS)] = 2**0.5  # of standard deviation 1
    np.testing.assert_allclose(found, expected, atol=1e-6)


@pytest.mark.parametrize("length", [1, 5, 31, 32, 100])
def test_step_means_keep_the_mean_of_the_recording(length):
    steps = 4
    graph = Graph()
    series, _ = float_input(graph, "force_series", ["N", "T", CHANNELS])
    graph.output("means", graph.op("Cast", step_means(graph, series, steps), to=1), ["N", steps * CHANNELS])
    values = np.random.default_rng(length).random((2, length, CHANNELS), np.float32)
    run = onnxruntime.InferenceSession(graph.model("means").SerializeToString()).run
    found = run(None, {"force_series": values})[0].reshape(2, steps, CHANNELS)
    fine = np.repeat(values, steps, axis=1).reshape(2, steps, length, CHANNELS).mean(axis=2)
    np.testing.assert_allclose(found, fine, atol=1e-6)
    np.testing.assert_allclose(found.mean(axis=1), values.mean(axis=1), atol=1e-6)
