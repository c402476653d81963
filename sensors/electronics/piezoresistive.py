"""The piezoresistive chain of FVSight: load -> conductance -> divider -> noise -> ADC -> force by calibration.

Divider and supply are the paper's (U = VCC R / (R1 + R), eq. 1; 3.3 V, 10 kOhm, 16 bits, rows isolated while
scanned, so no crosstalk). The conductance law G = G0 + c F^0.9 is a stated model: c puts the middle of
the range at 5 N.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.electronics.hysteresis import PrandtlIshlinskii

LOW_HYSTERESIS = PrandtlIshlinskii((0.5, 2.0, 6.0, 15.0), (0.004,) * 4)
"""0.19 N between the branches of a 50 N cycle, 0.4 % of full scale."""


@dataclass(frozen=True)
class PiezoresistiveChain:
    """Parameters of one array; forces in newtons, conductances in siemens."""

    supply_v: float = 3.3
    divider_ohm: float = 10e3
    adc_bits: int = 16
    rest_conductance_s: float = 1e-6
    midscale_force_n: float = 5.0
    exponent: float = 0.9
    noise_v: float = 1e-3
    hysteresis: PrandtlIshlinskii | None = LOW_HYSTERESIS

    @property
    def conductance_coefficient(self) -> float:
        """c in S / N^exponent: the divider gives half the supply at `midscale_force_n`."""
        return 1 / (self.divider_ohm * self.midscale_force_n**self.exponent)

    def voltage(self, response: NDArray[np.float64], gain: NDArray[np.float64] | float = 1.0) -> NDArray[np.float64]:
        """Divider voltage (V) for a hysteretic response (N); `gain` scales each taxel's conductance."""
        power = np.sign(response) * np.abs(response) ** self.exponent
        load_ratio = self.divider_ohm * (self.rest_conductance_s + self.conductance_coefficient * gain * power)
        # a relative conductance below zero has no meaning; an open circuit reads zero volts
        load_ratio = np.maximum(load_ratio, 0)
        return self.supply_v * load_ratio / (1 + load_ratio)

    def convert(self, voltage: NDArray[np.float64]) -> NDArray[np.float64]:
        """The voltage (V) that the ADC reports: clipped to the supply and rounded to its step."""
        steps = 2**self.adc_bits - 1
        return np.round(np.clip(voltage / self.supply_v, 0, 1) * steps) / steps * self.supply_v

    def calibrated_force(self, voltage: NDArray[np.float64]) -> NDArray[np.float64]:
        """Force (N) by the static calibration on a nominal taxel's loading branch."""
        ratio = np.minimum(voltage / self.supply_v, 1 - 2.0**-self.adc_bits)
        excess = ratio / (1 - ratio) / self.divider_ohm - self.rest_conductance_s
        response = np.sign(excess) * (np.abs(excess) / self.conductance_coefficient) ** (1 / self.exponent)
        return response if self.hysteresis is None else self.hysteresis.invert_loading(response)

    def read(
        self,
        load: NDArray[np.float64],
        rng: np.random.Generator | None = None,
        gain: NDArray[np.float64] | float = 1.0,
    ) -> NDArray[np.float64]:
        """Read-back forces (N) for true taxel loads (T, taxels) from rest; no noise where `rng` is None."""
        load = np.asarray(load, dtype=np.float64)
        response = load if self.hysteresis is None else self.hysteresis.respond(load)
        voltage = self.voltage(response, gain)
        if rng is not None and self.noise_v > 0:
            voltage = voltage + rng.normal(0.0, self.noise_v, voltage.shape)
        return self.calibrated_force(self.convert(voltage))
