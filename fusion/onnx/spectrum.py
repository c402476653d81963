"""Fourier coefficients of recordings of any length in a graph; on a period of the whole length they are exact sums."""

from __future__ import annotations

import numpy as np
from onnx import TensorProto

from fusion.onnx.builder import Graph, integers

EPS = float(np.finfo(np.float64).eps)


def fourier_coefficients(g: Graph, series: str, n_harmonics: int) -> str:
    """`fusion.features.FourierBasis(n_harmonics)` of series (N, T, channels), double: (N, harmonics x 2 x channels).

    With the recording's own length T as the period the basis is orthogonal on the samples, so that least squares is
    2 / T times the inner products, for every T. Harmonics that T cannot tell apart, 2 m + 1 > T, are 0.
    """
    z = _z_score(g, series)
    length = g.op("Shape", series, start=1, end=2)
    count = g.op("Squeeze", length, integers(0))
    t = g.op("Unsqueeze", g.op("Range", np.array(0), count, np.array(1)), integers(0))
    harmonic = np.arange(1, n_harmonics + 1)[:, None]
    turns = g.op("Mod", g.op("Mul", t, harmonic), length)  # whole numbers: no phase is lost in long recordings
    samples = g.double(length)
    angle = g.op("Mul", g.op("Div", g.double(turns), samples), 2 * np.pi)
    waves = g.op("Concat", *(g.op("Unsqueeze", g.op(f, angle), integers(1)) for f in ("Sin", "Cos")), axis=1)
    waves = g.op("Reshape", waves, g.op("Concat", integers(2 * n_harmonics), length, axis=0))
    fitted = g.op("LessOrEqual", np.repeat(2 * harmonic + 1, 2, axis=0), length)
    scale = g.op("Where", fitted, g.op("Div", 2.0, samples), 0.0)
    coefficients = g.op("Mul", g.op("MatMul", waves, z), scale)
    return g.op("Flatten", coefficients, axis=1)


def amplitudes(g: Graph, coefficients: str, n_harmonics: int, channels: int) -> str:
    """Amplitude (N, harmonics x channels) of each harmonic and channel."""
    pairs = g.op("Reshape", coefficients, integers(0, n_harmonics, 2, channels))
    return g.op("Flatten", g.op("Sqrt", g.sum(g.op("Mul", pairs, pairs), 2)), axis=1)


def _z_score(g: Graph, series: str) -> str:
    """As `fusion.features.spectrum.z_score`: a constant channel becomes 0."""
    centred = g.op("Sub", series, g.op("ReduceMean", series, integers(1), keepdims=1))
    spread = g.op("Sqrt", g.op("ReduceMean", g.op("Mul", centred, centred), integers(1), keepdims=1))
    rounding = g.op("Mul", g.op("ReduceMax", g.op("Abs", series), integers(1), keepdims=1), 10 * EPS)
    varies = g.op("Greater", spread, rounding)
    return g.op("Where", varies, g.op("Div", centred, g.op("Where", varies, spread, 1.0)), 0.0)


def single_precision(g: Graph, x: str) -> str:
    """`x` rounded to float32, as features are kept, and double again."""
    return g.double(g.op("Cast", x, to=TensorProto.FLOAT))
