"""`cfar`: the threshold beta for a chosen rate of false alarms, from a segment at rest."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from slip.detector import DifferenceDetector
from slip.resample import WINDOWS_PER_BLOCK, block_means, rate_interval, resampled_means
from slip.rest_noise import measure_rest, rms_draws
from slip.samples import Floats, as_sequence

DRAWS = 32  # rest segments that could have been
EXCEEDANCES = 4_000  # simulated samples above beta
FEWEST_SIMULATED = 200_000


@dataclass(frozen=True)
class Calibration:
    """A detector, the beta at which it says slip (score >= beta), and what is known of its false alarms.

    asked_rate : false alarms per sample, before hold-on, that `cfar` was asked for; None with `prior`.
    low, high : interval of the rate that beta really gives on white noise, from the error of beta's own estimate
        (rest segment and simulation); None with `prior`.
    rest_rate, rest_low, rest_high : rate measured on the rest samples, with a block-bootstrap interval.
    coloured : whether the rest noise departs from white, by its correlations or because the rate at rest lies
        above the asked one: noise whose size changes, with the load or from trial to trial, has white
        correlations; None with `prior`.
    """

    detector: DifferenceDetector
    beta: float
    method: str
    rest_rate: float
    rest_low: float
    rest_high: float
    asked_rate: float | None = None
    low: float | None = None
    high: float | None = None
    coloured: bool | None = None

    @property
    def gap(self) -> float:
        """Measured less asked rate per sample; NaN where no rate was asked."""
        return float("nan") if self.asked_rate is None else self.rest_rate - self.asked_rate

    def __str__(self) -> str:
        measured = f"{self.rest_rate:.3g} [{self.rest_low:.3g}, {self.rest_high:.3g}] at rest"
        if self.asked_rate is None:
            return f"beta {self.beta:.6g} ({self.method}): false alarms per sample {measured}"
        asked = f"asked {self.asked_rate:.3g} [{self.low:.3g}, {self.high:.3g}]"
        colour = f"; the rest noise is coloured or changes in size, gap {self.gap:+.3g}" if self.coloured else ""
        return f"beta {self.beta:.6g} ({self.method}): false alarms per sample {asked}, {measured}{colour}"


def cfar(
    detector: DifferenceDetector,
    rest: ArrayLike,
    rate: float,
    *,
    level: float = 0.95,
    seed: int = 0,
    most_simulated: int = 20_000_000,
) -> Calibration:
    """Find beta for `rate` false alarms per sample, before hold-on, from rest forces (T, taxels) in newtons.

    Taxels are whitened by the rms of their rest differences. Scores are then simulated for Gaussian noise that is
    white in force, around the rest's mean, whose true size is drawn from what it could be given the rest segment
    (bootstrap over blocks of 10 windows): the rate is met on average over rest segments, the error of the estimate
    counted in. For coloured noise the rate is off; the one measured on the rest segment stands beside it.

    Raises ValueError for a rest segment below 100 windows, one that never changes, a rate outside (0, 0.5), or one
    that would take more than `most_simulated` samples.
    """
    if not 0.0 < rate < 0.5:
        raise ValueError(f"expected a false-alarm rate per sample between 0 and 0.5, got {rate!r}")
    count = max(FEWEST_SIMULATED, int(np.ceil(EXCEEDANCES / rate)), 200 * DRAWS * detector.settling)
    if count > most_simulated:
        raise ValueError(
            f"a rate of {rate:g} takes {count} simulated samples, more than most_simulated={most_simulated}: ask "
            "for a higher rate per sample and a longer hold-on, or raise most_simulated"
        )
    force, kept = as_sequence(rest, detector.nan)
    force = force[kept]
    differences = np.diff(force, axis=0)
    rng = np.random.default_rng(seed)
    sizes = rms_draws(differences, detector.settling, DRAWS, rng) / np.sqrt(2.0)
    # The scale divides what is left of the differences after the common mode's treatment.
    plain = detector.with_scale(np.ones(force.shape[1]))
    noise = measure_rest(plain.treated_differences(force)[1:])
    whitened = detector.with_scale(noise.scale)
    centre = force.mean(axis=0)
    scores = [_rest_scores(whitened, centre, size, count // DRAWS, rng) for size in sizes]
    pooled = np.concatenate(scores)
    beta = _upper_quantile(pooled, rate)
    spread = _log_error(whitened, centre, sizes, pooled, beta, seed)
    reach = NormalDist().inv_cdf((1.0 + level) / 2.0) * spread
    settled = whitened.score(force)[whitened.settling :]
    measured, low, high = rate_interval(settled >= beta, whitened.settling, level=level, seed=seed)
    asked_low, asked_high = rate * float(np.exp(-reach)), rate * float(np.exp(reach))
    return Calibration(
        whitened,
        beta,
        "cfar",
        measured,
        low,
        high,
        asked_rate=rate,
        low=asked_low,
        high=asked_high,
        coloured=measure_rest(differences).coloured or low > asked_high,
    )


def _rest_scores(
    detector: DifferenceDetector, centre: Floats, size: Floats, samples: int, rng: np.random.Generator
) -> Floats:
    force = rng.standard_normal((samples + detector.settling, len(centre)))
    force *= size
    force += centre
    return detector.score(force)[detector.settling :]


def _upper_quantile(scores: Floats, rate: float) -> float:
    rank = max(int(np.floor(rate * (len(scores) + 1))), 1)
    return float(np.partition(scores, len(scores) - rank)[len(scores) - rank])


def _log_error(
    detector: DifferenceDetector, centre: Floats, sizes: Floats, pooled: Floats, beta: float, seed: int
) -> float:
    """Standard error of log(rate at beta): the rest segment's part on common random numbers, and the simulation's."""
    samples = max(len(pooled) // (4 * len(sizes)), 20 * detector.settling)
    rates = [
        float((_rest_scores(detector, centre, size, samples, np.random.default_rng([seed, 1])) >= beta).mean())
        for size in sizes
    ]
    mean = float(np.mean(rates))
    from_rest = float(np.std(rates)) / mean if mean > 0.0 else 1.0
    blocks = block_means(pooled >= beta, WINDOWS_PER_BLOCK * detector.settling)
    drawn = resampled_means(blocks, 500, np.random.default_rng([seed, 2]))
    return float(np.hypot(from_rest, drawn.std() / drawn.mean()))
