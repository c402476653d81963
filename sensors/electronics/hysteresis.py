"""Prandtl-Ishlinskii hysteresis: a weighted sum of play operators.

y = x + sum_i w_i (P_i[x] - x), where the play P of threshold r follows p_t = min(max(p_{t-1}, x_t - r), x_t + r).

Source: K. Kuhnen, "Modeling, identification and compensation of complex hysteretic nonlinearities", European Journal
of Control 9 (2003) 407-418.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.compiled import compiled


def play(x: NDArray[np.float64], threshold: float) -> NDArray[np.float64]:
    """Play operator along axis 0 from rest (p = 0 before the first sample); same shape as `x`."""
    x = np.ascontiguousarray(x, dtype=np.float64)
    return np.asarray(_follow(x.reshape(len(x), math.prod(x.shape[1:])), float(threshold))).reshape(x.shape)


@compiled
def _follow(x: NDArray[np.float64], threshold: float) -> NDArray[np.float64]:
    out = np.empty_like(x)
    state = np.zeros(x.shape[1])
    for t in range(x.shape[0]):
        for column in range(x.shape[1]):
            held = min(max(state[column], x[t, column] - threshold), x[t, column] + threshold)
            state[column] = held
            out[t, column] = held
    return out


@dataclass(frozen=True)
class PrandtlIshlinskii:
    """Play thresholds (N) and their weights (dimensionless, each >= 0, their sum < 1)."""

    thresholds_n: tuple[float, ...]
    weights: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.thresholds_n) != len(self.weights):
            raise ValueError(f"{len(self.thresholds_n)} thresholds but {len(self.weights)} weights")
        values = (*self.weights, *self.thresholds_n)
        if not (all(0 <= value < np.inf for value in values) and sum(self.weights) < 1):
            raise ValueError("thresholds and weights must be >= 0 and the weights must sum to less than 1")

    def respond(self, force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Hysteretic response (N) to a force history (T, ...), starting at rest."""
        force = np.asarray(force, dtype=np.float64)
        response = force.copy()
        for threshold, weight in zip(self.thresholds_n, self.weights, strict=True):
            response += weight * (play(force, threshold) - force)
        return response

    def invert(self, response: NDArray[np.float64]) -> NDArray[np.float64]:
        """The force history (T, ...) whose `respond` is `response`: the exact inverse, for any history from rest.

        It is a Prandtl-Ishlinskii operator too: its thresholds lie on the loading branch, its weights are negative.
        """
        response = np.asarray(response, dtype=np.float64)
        order = np.argsort(self.thresholds_n, kind="stable")
        thresholds = self.loading_branch(np.array(self.thresholds_n, dtype=np.float64)[order])
        slope = 1 - sum(self.weights)
        force = response / slope
        for threshold, weight in zip(thresholds, np.array(self.weights)[order], strict=True):
            force -= weight / (slope * (slope + weight)) * play(response, float(threshold))
            slope += weight
        return force

    def loading_branch(self, force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Response to a first, monotone loading from rest to `force` >= 0 (odd for negative values)."""
        response = np.asarray(force, dtype=np.float64).copy()
        for threshold, weight in zip(self.thresholds_n, self.weights, strict=True):
            response -= weight * np.clip(force, -threshold, threshold)
        return response

    def invert_loading(self, response: NDArray[np.float64]) -> NDArray[np.float64]:
        """The force whose loading branch is `response`: what a static calibration knows."""
        knots = np.array([0.0, *sorted(self.thresholds_n)])
        values = self.loading_branch(knots)
        size = np.abs(response)
        inner = np.interp(size, values, knots)
        # beyond the last threshold every play follows at unit slope
        beyond = knots[-1] + (size - values[-1])
        return np.sign(response) * np.where(size > values[-1], beyond, inner)
