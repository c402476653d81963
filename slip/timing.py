"""What the covariance detector costs beside a plain recomputation of each window, measured in one interleaved run."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slip.covariance import Covariance, plain_norm
from slip.samples import Floats
from slip.windows import pad_front

BATCH_SAMPLES = 60_000
"""A minute at 1 kHz: what a call costs beside the samples does not show."""
PLAIN_SAMPLES = 2_000


@dataclass(frozen=True)
class Cost:
    """CPU microseconds a sample of one form of the detector, and how many times those of the batch.

    us, ratio : (median, least, most) over the repeats; a ratio is taken within each repeat.
    """

    form: str
    us: tuple[float, float, float]
    ratio: tuple[float, float, float]


def covariance_cost(window: int = 50, taxels: int = 16, repeats: int = 15, seed: int = 0) -> list[Cost]:
    """Measure batch, stream, and two plain recomputations of the covariance detector on white noise, batch first.

    Every repeat runs all forms once, after a warm-up; single thread where the numerical libraries are held to one.
    Raises ValueError for a window below 2, no taxel, or no repeat.
    """
    if taxels < 1 or repeats < 1:
        raise ValueError(f"expected at least one taxel and one repeat, got {taxels} and {repeats}")
    detector = Covariance(window)
    force = 1.0 + 0.02 * np.random.default_rng(seed).standard_normal((BATCH_SAMPLES, taxels))
    few = force[: max(PLAIN_SAMPLES, 4 * window)]

    def stream() -> None:
        detector.reset()
        for sample in few:
            detector.update(sample)

    forms: dict[str, tuple[Callable[[], object], int]] = {
        "batch": (lambda: detector.score(force), len(force)),
        "stream, from Python": (stream, len(few)),
        "plain NumPy, word for word": (lambda: plain_norm(few, window), len(few)),
        "plain NumPy, lean": (lambda: lean_norm(few, window), len(few)),
    }
    spent = np.empty((repeats + 1, len(forms)))
    for row in spent:
        for at, (call, samples) in enumerate(forms.values()):
            start = time.thread_time_ns()
            call()
            row[at] = (time.thread_time_ns() - start) / samples / 1e3
    spent = spent[1:]
    return [Cost(form, _spread(us), _spread(us / spent[:, 0])) for form, us in zip(forms, spent.T, strict=True)]


def lean_norm(force: Floats, window: int = 50) -> Floats:
    """`plain_norm` with all that can be done once done once: differences, absolute values in place; (T,) N^2."""
    differences = np.zeros(force.shape)
    np.subtract(force[1:], force[:-1], out=differences[1:])
    padded, phi = pad_front(differences, window - 1), np.empty((window, window))
    diagonal = phi.reshape(-1)[:: window + 1]
    scores = np.empty(len(force))
    for t in range(len(scores)):
        chi = padded[t : t + window]
        np.abs(np.matmul(chi, chi.T, out=phi), out=phi)
        diagonal[:] = 0.0
        scores[t] = phi.sum(axis=1).max()
    return scores


def _spread(values: Floats) -> tuple[float, float, float]:
    return float(np.median(values)), float(values.min()), float(values.max())
