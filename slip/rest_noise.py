"""What a rest segment says about the noise: its size on each taxel, and how far it is from white."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slip.resample import WINDOWS_PER_BLOCK, block_means, resampled_means
from slip.samples import Floats

WHITE_AUTOCORRELATION = (-0.5, 0.0, 0.0, 0.0, 0.0)  # of the differences of white noise, lags 1 to 5
COLOURED_AT = 4.0  # standard errors


@dataclass(frozen=True)
class RestNoise:
    """Noise of the force differences at rest.

    rms : (taxels,) newtons, 0 where a taxel never changed.
    scale : (taxels,) newtons, `rms` with the median of the others where it is 0: a dead taxel stays silent
        whatever its scale, a quiet one that wakes up is not lost.
    colour : largest departure from white of the autocorrelation (mean over taxels) or of the mean correlation
        between taxels; `coloured` where it is beyond 4 standard errors.
    """

    rms: Floats
    scale: Floats
    colour: float
    coloured: bool


def measure_rest(differences: Floats) -> RestNoise:
    """Measure rest differences (T, taxels) in newtons. Raises ValueError where no taxel ever changes."""
    rms = np.sqrt((differences * differences).mean(axis=0))
    heard = rms > 0.0
    if not heard.any():
        raise ValueError("expected noise in the rest segment, got forces that never change on any taxel")
    scale = np.where(heard, rms, np.median(rms[heard]))
    colour, error = _departure_from_white(differences[:, heard] / rms[heard])
    return RestNoise(rms, scale, colour, colour > COLOURED_AT * error)


def rms_draws(differences: Floats, window: int, draws: int, rng: np.random.Generator) -> Floats:
    """Draw what `rms` could have been from other rest segments as long, by blocks of 10 windows; (draws, taxels)."""
    squares = block_means(differences * differences, WINDOWS_PER_BLOCK * window)
    return np.sqrt(resampled_means(squares, draws, rng))


def _departure_from_white(standard: Floats) -> tuple[float, float]:
    samples, taxels = standard.shape
    lags = [
        abs(float((standard[lag:] * standard[:-lag]).mean()) - white)
        for lag, white in enumerate(WHITE_AUTOCORRELATION, start=1)
    ]
    # Var of a lagged product's mean, for the differences of white noise, is at most 2 / (T taxels).
    colour, error = max(lags), float(np.sqrt(2.0 / (samples * taxels)))
    if taxels > 1:
        total = standard.sum(axis=1)
        pairs = taxels * (taxels - 1)
        between = abs(float((total * total - (standard * standard).sum(axis=1)).mean())) / pairs
        between_error = float(np.sqrt(3.0 / (samples * pairs)))
        if between / between_error > colour / error:
            return between, between_error
    return colour, error
