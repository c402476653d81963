"""How the taxels of one array differ from the nominal one, and how they drift from session to session."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sensors.electronics.piezoresistive import PiezoresistiveChain


@dataclass(frozen=True)
class ArrayTraits:
    """Relative conductance (n,), offset of the read-back force (n,; N) and open circuits (n,; bool) of n taxels."""

    gain: NDArray[np.float64]
    offset_n: NDArray[np.float64]
    dead: NDArray[np.bool_]

    @classmethod
    def draw(
        cls,
        rng: np.random.Generator,
        taxels: int,
        gain_spread: float = 0.03,
        offset_n: float = 0.0,
        dead_share: float = 0.0,
    ) -> ArrayTraits:
        """An array with log-normal gains, normal offsets (N) and each taxel dead with probability `dead_share`."""
        if not (0 <= gain_spread < np.inf and 0 <= offset_n < np.inf and 0 <= dead_share <= 1):
            raise ValueError(
                "an array needs gain_spread >= 0, offset_n >= 0 and dead_share in 0..1, got "
                f"{gain_spread}, {offset_n}, {dead_share}"
            )
        gain, offset = np.exp(gain_spread * rng.standard_normal(taxels)), offset_n * rng.standard_normal(taxels)
        return cls(gain, offset, rng.random(taxels) < dead_share)

    def drift(self, rng: np.random.Generator, gain: float = 0.01, offset_n: float = 0.02) -> ArrayTraits:
        """The same array in its next session: gains move by `gain` (relative), offsets by `offset_n` (N)."""
        if not (0 <= gain < np.inf and 0 <= offset_n < np.inf):
            raise ValueError(f"a drift needs gain >= 0 and offset_n >= 0, got {gain}, {offset_n}")
        taxels = len(self.gain)
        return replace(
            self,
            gain=self.gain * np.exp(gain * rng.standard_normal(taxels)),
            offset_n=self.offset_n + offset_n * rng.standard_normal(taxels),
        )

    def read(
        self, chain: PiezoresistiveChain, load: NDArray[np.float64], rng: np.random.Generator | None = None
    ) -> NDArray[np.float64]:
        """Read-back forces (T, n; N) of this array for true loads (T, n; N)."""
        return chain.read(load, rng, self.gain, self.dead) + self.offset_n
