"""The few operations in which the nets are written, on NumPy arrays and on torch tensors alike.

Everything else that a net does (`@`, `+`, `*`, `/`, `**`, `reshape`, `swapaxes`, `mean`) both kinds of array have as
methods, so a net is written once: torch learns its weights, NumPy predicts with them, a graph records it for ONNX.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

Array = Any
"""A NumPy array, a torch tensor, or a value of a graph."""


class Ops(Protocol):
    """Operations that the kinds of array name differently."""

    def relu(self, x: Array) -> Array:
        """max(x, 0)."""

    def softmax(self, x: Array) -> Array:
        """Softmax over the last axis."""

    def concat(self, parts: Sequence[Array], axis: int) -> Array:
        """Arrays side by side along an axis."""


class NumpyOps:
    """On NumPy arrays."""

    def relu(self, x: Array) -> Array:
        """max(x, 0)."""
        return np.maximum(x, 0.0)

    def softmax(self, x: Array) -> Array:
        """Softmax over the last axis."""
        raised = np.exp(x - x.max(axis=-1, keepdims=True))
        return raised / raised.sum(axis=-1, keepdims=True)

    def concat(self, parts: Sequence[Array], axis: int) -> Array:
        """Arrays side by side along an axis."""
        return np.concatenate(list(parts), axis=axis)


class TorchOps:
    """On torch tensors; made only where torch is loaded."""

    def __init__(self) -> None:
        import torch

        self._torch = torch

    def relu(self, x: Array) -> Array:
        """max(x, 0)."""
        return self._torch.relu(x)

    def softmax(self, x: Array) -> Array:
        """Softmax over the last axis."""
        return self._torch.softmax(x, dim=-1)

    def concat(self, parts: Sequence[Array], axis: int) -> Array:
        """Arrays side by side along an axis."""
        return self._torch.cat(list(parts), dim=axis)
