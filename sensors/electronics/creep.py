"""Creep and release overshoot of a carbon-filled sheet: its conductance is low after every change of load.

    G(t) = G_eq(F) (1 - sum_i b_i |m_i - u|)      m_i' = (u - m_i) / tau_i      u = F / (F + F_c)

u says how closed the sheet's contacts are, m_i remember how closed they were. On a hold the memories catch up and the
resistance falls; at release u drops to 0 while they are late, so the resistance overshoots its rest value and comes
back with the same times. One mechanism and one set of constants for both: a stated model, not one from a paper.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Creep:
    """Memory times tau_i (s), their depths b_i (sum < 1) and the closing force F_c (N) at which u is one half."""

    times_s: tuple[float, ...]
    depths: tuple[float, ...]
    closing_force_n: float

    def __post_init__(self) -> None:
        if len(self.times_s) != len(self.depths):
            raise ValueError(f"creep needs one depth for each time, got {len(self.times_s)} and {len(self.depths)}")
        if not all(0 < value < np.inf for value in (*self.times_s, self.closing_force_n)):
            raise ValueError("creep needs finite times_s > 0 and closing_force_n > 0")
        if not (all(depth >= 0 for depth in self.depths) and sum(self.depths) < 1):
            raise ValueError("creep needs depths >= 0 that sum to less than 1")

    def closed(self, load: NDArray[np.float64]) -> NDArray[np.float64]:
        """u, the share of the sheet's contacts that a load (N) closes: 0 without load, towards 1."""
        load = np.maximum(load, 0)
        return load / (load + self.closing_force_n)

    def factor(self, load: NDArray[np.float64], rate_hz: float) -> NDArray[np.float64]:
        """What multiplies the equilibrium conductance under loads (T, ...; N) sampled at `rate_hz`, from rest.

        Exact for a load that is constant between samples.
        """
        from scipy.signal import lfilter

        closed = self.closed(load)
        lost = np.zeros(np.shape(load))
        for time_s, depth in zip(self.times_s, self.depths, strict=True):
            keep = np.exp(-1 / (time_s * rate_hz))
            # the memory that a sample meets was formed by the samples before it
            memory = lfilter([0, 1 - keep], [1, -keep], closed, axis=0)
            lost += depth * np.abs(memory - closed)
        return 1 - lost
