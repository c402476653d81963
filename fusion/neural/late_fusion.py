"""Late fusion: an encoder for each modality, joined in the last hidden layer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fusion.neural.layout import Layout, Part
from fusion.neural.net import RELU_GAIN, Start, Weights, affine, largest_divisor, linear, patches
from fusion.neural.ops import Array, Ops

PATCH = 4  # pixels, at most
MERGE = 2  # patches in each direction
WINDOW = 4  # steps, at most


@dataclass(frozen=True)
class LateFusion:
    """An image is read in patches of 4 x 4 and these in blocks of 2 x 2, a series in windows of 4 steps.

    Every modality ends in `width` numbers, and the last hidden layer adds what each says. A missing one adds
    nothing, and the others are raised by modalities / present ones in its place.
    """

    layout: Layout
    n_classes: int
    width: int

    def starts(self) -> dict[str, Start]:
        """Every weight of the net."""
        found: dict[str, Start] = {}
        for part in self.layout.parts:
            found |= self._encoder(part)
            found |= {f"{part.name}.join": Start((self.width, self.width), RELU_GAIN * self.width**-0.5)}
        return found | {"join.bias": Start((self.width,))} | linear("out", self.width, self.n_classes)

    def logits(self, ops: Ops, weights: Weights, parts: Mapping[str, Array], present: Array | None = None) -> Array:
        """See `fusion.neural.net.Net`."""
        there = len(parts) if present is None else present.sum(axis=1).reshape(-1, 1)
        total = None
        for number, part in enumerate(self.layout.parts):
            if part.name not in parts:
                continue
            said = self._encode(ops, weights, part, parts[part.name]) @ weights[f"{part.name}.join"]
            if present is not None:
                said = said * present[:, number : number + 1]
            total = said if total is None else total + said
        assert total is not None
        hidden = ops.relu(total * (len(self.layout.parts) / there) + weights["join.bias"])
        return affine(weights, "out", hidden)

    def _encoder(self, part: Part) -> dict[str, Start]:
        inner = self.width // 2
        if part.kind == "vector":
            return linear(f"{part.name}.encode", part.shape[0], self.width, RELU_GAIN)
        if part.kind == "series":
            window = largest_divisor(part.shape[0], WINDOW)
            flat = part.shape[0] // window * inner
            first = linear(f"{part.name}.window", window * part.shape[1], inner, RELU_GAIN)
        else:
            down, across, merge = _cut(part.shape)
            blocks = part.shape[1] // down * (part.shape[2] // across) // merge**2
            flat = blocks * inner
            first = linear(f"{part.name}.patch", down * across * part.shape[0], inner, RELU_GAIN)
            first |= linear(f"{part.name}.block", merge**2 * inner, inner, RELU_GAIN)
        return first | linear(f"{part.name}.encode", flat, self.width, RELU_GAIN)

    def _encode(self, ops: Ops, weights: Weights, part: Part, x: Array) -> Array:
        """(n, *shape) -> (n, width)."""
        inner = self.width // 2
        if part.kind == "series":
            steps, channels = part.shape
            window = largest_divisor(steps, WINDOW)
            x = x.reshape(-1, steps // window, window * channels)
            x = ops.relu(affine(weights, f"{part.name}.window", x)).reshape(-1, steps // window * inner)
        elif part.kind == "image":
            down, across, merge = _cut(part.shape)
            rows, columns = part.shape[1] // down, part.shape[2] // across
            x = ops.relu(affine(weights, f"{part.name}.patch", patches(x, part.shape, down, across)))
            x = x.reshape(-1, rows // merge, merge, columns // merge, merge * inner).swapaxes(2, 3)
            blocks = rows * columns // merge**2
            x = ops.relu(affine(weights, f"{part.name}.block", x.reshape(-1, blocks, merge**2 * inner)))
            x = x.reshape(-1, blocks * inner)
        return ops.relu(affine(weights, f"{part.name}.encode", x))


def _cut(shape: tuple[int, ...]) -> tuple[int, int, int]:
    """Rows and columns of a patch, and patches of a block in each direction."""
    down, across = largest_divisor(shape[1], PATCH), largest_divisor(shape[2], PATCH)
    even = shape[1] // down % MERGE == 0 and shape[2] // across % MERGE == 0
    return down, across, MERGE if even else 1
