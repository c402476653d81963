"""The capacitive chain: load -> squeezed dielectric -> counts above rest -> low-pass -> slow sampling -> whole counts.

C = eps A / d: a dielectric squeezed by the share s has dC / C0 = s / (1 - s), with s = s_max F / (F + F_half) for an
elastomer that stiffens. The converter's firmware takes the counts at rest away, so that no load reads 0. Sampling
period, noise and bandwidth follow the public recordings of a CPM-Finger (28 ms, one count, a fall above a few hertz);
what a count is in newtons was never published: the sensitivity is an assumption.

Source: the parallel plates of H. Wang et al., "Fabric classification using a finger-shaped tactile sensor via robotic
sliding", Front. Neurorobot. 16, 2022; the stiffening is ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.electronics.given import finite_load


@dataclass(frozen=True)
class CapacitiveChain:
    """Parameters of one array: squeeze (share, N), converter (counts), low-pass (Hz) and sampling period (ms)."""

    full_squeeze: float = 0.5
    half_load_n: float = 4.0
    rest_counts: float = 4800.0
    bandwidth_hz: float = 5.0
    period_ms: float = 28.0
    noise_counts: float = 1.0
    top_counts: float = 4095.0

    def __post_init__(self) -> None:
        if not 0 < self.full_squeeze < 1:
            raise ValueError(f"full_squeeze must lie between 0 and 1, got {self.full_squeeze}")
        positive = (self.half_load_n, self.rest_counts, self.bandwidth_hz, self.period_ms, self.top_counts)
        if not all(0 < value < np.inf for value in positive):
            raise ValueError("a capacitive chain needs half load, rest counts, bandwidth, period and top counts > 0")
        if not 0 <= self.noise_counts < np.inf:
            raise ValueError(f"noise_counts must be >= 0, got {self.noise_counts}")

    @property
    def rate_hz(self) -> float:
        """Samples a second."""
        return 1e3 / self.period_ms

    def counts(self, load: NDArray[np.float64]) -> NDArray[np.float64]:
        """Static counts above rest for loads (N), before noise and rounding; 0 without load."""
        load = np.maximum(load, 0)
        squeeze = self.full_squeeze * load / (load + self.half_load_n)
        return self.rest_counts * squeeze / (1 - squeeze)

    def load(self, counts: NDArray[np.float64]) -> NDArray[np.float64]:
        """The load (N) whose static counts these are: the inverse of `counts` for 0 <= counts below full squeeze."""
        change = counts / self.rest_counts
        squeeze = change / (1 + change)
        return self.half_load_n * squeeze / (self.full_squeeze - squeeze)

    def read(
        self,
        load: NDArray[np.float64],
        rate_hz: float,
        rng: np.random.Generator | None = None,
        gain: NDArray[np.float64] | float = 1.0,
        settled: bool = False,
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
        """Times (M,; s) and whole counts (M, taxels) for loads (T, taxels; N) sampled at `rate_hz`.

        Starts at rest, or with `settled` long under the first load. `gain` scales the counts taxel by taxel. No noise
        without `rng`. Raises ValueError for a load or gain that is not finite, a gain < 0, and where `rate_hz` is below
        the sampling rate.
        """
        from scipy.signal import lfilter

        if rate_hz < self.rate_hz:
            raise ValueError(f"loads must come at {self.rate_hz:g} Hz or faster, got rate_hz={rate_hz:g}")
        ideal = self.counts(finite_load(load, gain)) * gain
        keep = np.exp(-2 * np.pi * self.bandwidth_hz / rate_hz)
        before = keep * ideal[:1] if settled else np.zeros_like(ideal[:1])
        slow, _ = lfilter([1 - keep], [1, -keep], ideal, axis=0, zi=before)
        at = np.arange(0, len(ideal), rate_hz / self.rate_hz).astype(int)
        seen = slow[at]
        if rng is not None:
            seen = seen + self.noise_counts * rng.standard_normal(seen.shape)
        time = np.arange(len(at)) / self.rate_hz
        return time, np.clip(np.rint(seen), -self.top_counts, self.top_counts).astype(np.float32)
