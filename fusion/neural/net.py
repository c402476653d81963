"""What the nets share: weights by name with their starting spread, and layers written in `fusion.neural.ops`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fusion.neural.layout import Layout
from fusion.neural.ops import Array, Ops

RELU_GAIN = 2.0**0.5  # He: keeps the spread through a rectifier
Weights = Mapping[str, Array]


@dataclass(frozen=True)
class Start:
    """How a weight starts: normal with this standard deviation about `centre`."""

    shape: tuple[int, ...]
    deviation: float = 0.0
    centre: float = 0.0


class Net(Protocol):
    """Sizes of a net; its weights are held apart."""

    @property
    def layout(self) -> Layout:
        """The modalities that it takes."""

    def starts(self) -> dict[str, Start]:
        """Every weight of the net."""

    def logits(self, ops: Ops, weights: Weights, parts: Mapping[str, Array], present: Array | None = None) -> Array:
        """Logits (n, classes) of scaled modalities, each (n, *shape).

        A modality that is not among `parts` is missing from every row; `present` (n, modalities of the layout)
        says 0 where one is missing from a row, None that all `parts` are there.
        """


def start_weights(net: Net, rng: np.random.Generator) -> dict[str, NDArray[np.float32]]:
    """Random weights of a net."""
    return {
        name: (start.centre + start.deviation * rng.standard_normal(start.shape)).astype(np.float32)
        for name, start in net.starts().items()
    }


def linear(name: str, inputs: int, outputs: int, gain: float = 1.0) -> dict[str, Start]:
    """Weights of one affine layer."""
    return {name: Start((inputs, outputs), gain * inputs**-0.5), f"{name}.bias": Start((outputs,))}


def affine(weights: Weights, name: str, x: Array) -> Array:
    """x (..., inputs) -> (..., outputs)."""
    return x @ weights[name] + weights[f"{name}.bias"]


def largest_divisor(number: int, most: int) -> int:
    """Largest divisor of a number that is at most `most`."""
    return max(d for d in range(1, min(number, most) + 1) if number % d == 0)


def patches(x: Array, shape: tuple[int, ...], down: int, across: int) -> Array:
    """Images (n, channels, rows, columns) -> patches (n, patches, down * across * channels), row by row."""
    channels, rows, columns = shape
    cut = x.reshape(-1, channels, rows // down, down, columns // across, across)
    cut = cut.swapaxes(1, 2).swapaxes(2, 4)
    return cut.reshape(-1, rows // down * (columns // across), down * across * channels)
