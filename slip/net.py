"""A causal convolutional net over force differences, in NumPy: whole sequences, or a sample at a time.

The first layer takes the compressed differences; each later one sees twice as far back and adds to what it was given:
h <- h + relu(conv(h)). A hidden layer then joins what the forces say with an embedding of the camera's last frames,
where there is a camera, and gives the logit z of slip. The score is softplus(z) = -log P(no slip): it rises with z
without end, where a probability would saturate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from slip.samples import Floats

KERNEL = 3
ROWS_AT_A_TIME = 16_384


@dataclass(frozen=True)
class NetShape:
    """Sizes of a net; `levels` layers at dilations 1, 2, 4, ... ; `embedding` 0 is a net without camera."""

    taxels: int
    channels: int = 24
    levels: int = 7
    hidden: int = 16
    embedding: int = 0
    grid: int = 16
    patch: int = 4
    patch_features: int = 8

    def __post_init__(self) -> None:
        if min(self.taxels, self.channels, self.levels, self.hidden, self.patch, self.patch_features) < 1:
            raise ValueError(f"expected sizes of at least 1, got {self}")
        if self.levels > 12 or self.embedding < 0 or self.grid < 1 or self.grid % self.patch:
            raise ValueError(f"expected levels up to 12 and a grid in whole patches, got {self}")

    @property
    def reach(self) -> int:
        """Differences that a score depends on."""
        return 1 + (KERNEL - 1) * (2**self.levels - 1)

    @property
    def cells(self) -> int:
        """Patches of a frame."""
        return (self.grid // self.patch) ** 2

    def weights(self) -> dict[str, tuple[int, ...]]:
        """Name and shape of every weight; a convolution is (taps x inputs, outputs), the oldest tap first."""
        shapes: dict[str, tuple[int, ...]] = {}
        for level in range(self.levels):
            inputs = self.channels if level else self.taxels
            shapes[f"conv{level}"] = (KERNEL * inputs, self.channels)
        if self.embedding:
            shapes["patch"] = (self.patch * self.patch * 3, self.patch_features)
            shapes["motion"] = (KERNEL * self.cells * self.patch_features, self.embedding)
        shapes["hidden"] = (self.channels + self.embedding, self.hidden)
        shapes["slip"] = (self.hidden, 1)
        return shapes | {f"{name}.bias": shape[1:] for name, shape in shapes.items()}

    @property
    def parameters(self) -> int:
        """Number of weights."""
        return sum(int(np.prod(shape)) for shape in self.weights().values())


@dataclass(frozen=True)
class Net:
    """A trained net: its shape, float32 weights by name, and the size of frame changes at rest."""

    shape: NetShape
    weights: Mapping[str, Floats] = field(repr=False)
    frame_scale: float = 1.0

    def __post_init__(self) -> None:
        for name, shape in self.shape.weights().items():
            found = self.weights[name].shape if name in self.weights else None
            if found != shape or not np.isfinite(self.weights[name]).all():
                raise ValueError(f"expected finite weights {name!r} of shape {shape}, got {found or 'none'}")

    def layer(self, values: Floats, name: str) -> Floats:
        """The named linear layer of (..., inputs)."""
        return values @ self.weights[name] + self.weights[f"{name}.bias"]

    def scores(self, differences: Floats, held: Floats) -> Floats:
        """Scores (T,) of a fresh stream of differences (T, taxels) and held embeddings (T, embedding)."""
        scores = np.empty(len(differences))
        overlap = self.shape.reach - 1
        for first in range(0, len(differences), ROWS_AT_A_TIME):
            start = max(first - overlap, 0)
            stop = first + ROWS_AT_A_TIME
            values = compress(differences[start:stop])
            for level in range(self.shape.levels):
                past = np.zeros(((KERNEL - 1) << level, values.shape[1]))
                values = self._convolve(np.concatenate([past, values]), values, level)
            scores[first:stop] = self.head(values[first - start :], held[first:stop])
        return scores

    def head(self, values: Floats, held: Floats) -> Floats:
        """Scores (T,) from the last layer's (T, channels) and the embeddings (T, embedding)."""
        hidden = relu(self.layer(np.concatenate([values, held], axis=1), "hidden"))
        return softplus(self.layer(hidden, "slip")[:, 0])

    def _convolve(self, padded: Floats, values: Floats, level: int) -> Floats:
        rows = [padded[tap << level : len(values) + (tap << level)] for tap in range(KERNEL)]
        out = relu(self.layer(np.concatenate(rows, axis=1), f"conv{level}"))
        return values + out if level else out


class NetStream:
    """The running state of a net over differences: the inputs that each of its layers still looks back on."""

    def __init__(self, net: Net, held: HeldEmbedding) -> None:
        self._net, self._held = net, held
        shape = net.shape
        widths = [shape.taxels] + [shape.channels] * (shape.levels - 1)
        self._rings = [np.zeros((((KERNEL - 1) << level) + 1, width)) for level, width in enumerate(widths)]
        self._samples = 0

    def push(self, difference: Floats) -> float:
        """Take the next difference (taxels,); return the score."""
        net, values = self._net, compress(difference)
        for level, ring in enumerate(self._rings):
            ring[self._samples % len(ring)] = values
            taps = [(self._samples + 1 + (tap << level)) % len(ring) for tap in range(KERNEL)]
            out = relu(net.layer(ring[taps].reshape(-1), f"conv{level}"))
            values = values + out if level else out
        self._samples += 1
        return float(net.head(values[None], self._held.embedding[None])[0])


class HeldEmbedding:
    """What the net is told of the camera until the next frame: nothing, that is zeros, without one."""

    def __init__(self, size: int) -> None:
        self.embedding = np.zeros(size)


def compress(values: Floats) -> Floats:
    """sign(x) log(1 + |x|): noise passes nearly unchanged, a shock does not drown the rest."""
    return np.sign(values) * np.log1p(np.abs(values))


def relu(values: Floats) -> Floats:
    """Negative values become 0."""
    return np.maximum(values, 0.0)


def softplus(logit: Floats) -> Floats:
    """log(1 + e^z) without overflow."""
    return np.logaddexp(0.0, logit)
