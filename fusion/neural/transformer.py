"""A small transformer over image patches, taxels and stretches of time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fusion.neural.layout import Layout, Part
from fusion.neural.net import RELU_GAIN, Start, Weights, affine, largest_divisor, linear, patches
from fusion.neural.ops import Array, Ops

GRID = 4  # patches in each direction, at most
WINDOW = 4  # steps, at most
EPSILON = 1e-5
UNSEEN = -1e9  # added to the attention paid to a missing token
POSITION = 0.1  # standard deviation of a token's position at the start


@dataclass(frozen=True)
class Transformer:
    """Tokens of all modalities attend to each other; a learnt query pools them.

    An image gives a token a patch (at most 4 x 4 of them), a series one a channel (its history) and one for
    every 4 steps (all channels), a vector one. Missing modalities give no tokens.
    """

    layout: Layout
    n_classes: int
    width: int
    heads: int
    layers: int

    def starts(self) -> dict[str, Start]:
        """Every weight of the net."""
        d = self.width
        found: dict[str, Start] = {}
        for part in self.layout.parts:
            for name, (count, inputs) in _tokens(part).items():
                found |= linear(f"{name}.in", inputs, 2 * d, RELU_GAIN) | linear(f"{name}.token", 2 * d, d)
                found[f"{name}.position"] = Start((count, d), POSITION)
        for layer in range(self.layers):
            at = f"layer{layer}"
            found |= _norm(f"{at}.attend", d) | _norm(f"{at}.think", d)
            for name in ("query", "key", "value", "attended"):
                found |= linear(f"{at}.{name}", d, d)
            found |= linear(f"{at}.wide", d, 2 * d, RELU_GAIN) | linear(f"{at}.narrow", 2 * d, d)
        found["pool"] = Start((d, 1), d**-0.5)
        return found | _norm("last", d) | linear("out", d, self.n_classes)

    def logits(self, ops: Ops, weights: Weights, parts: Mapping[str, Array], present: Array | None = None) -> Array:
        """See `fusion.neural.net.Net`."""
        tokens, unseen, count = [], [], 0
        for number, part in enumerate(self.layout.parts):
            if part.name not in parts:
                continue
            for name, (n_tokens, _) in _tokens(part).items():
                inputs = _cut(part, name, parts[part.name])
                embedded = affine(weights, f"{name}.token", ops.relu(affine(weights, f"{name}.in", inputs)))
                tokens.append(embedded + weights[f"{name}.position"])
                count += n_tokens
                if present is not None:
                    unseen += [(1.0 - present[:, number : number + 1]) * UNSEEN] * n_tokens
        x = ops.concat(tokens, 1)
        hidden = ops.concat(unseen, 1) if unseen else None
        for layer in range(self.layers):
            x = x + self._attend(ops, weights, f"layer{layer}", x, count, hidden)
            inner = affine(weights, f"layer{layer}.wide", _normed(weights, f"layer{layer}.think", x))
            x = x + affine(weights, f"layer{layer}.narrow", ops.relu(inner))
        x = _normed(weights, "last", x)
        share = (x @ weights["pool"]).reshape(-1, 1, count)
        share = ops.softmax(share if hidden is None else share + hidden.reshape(-1, 1, count))
        return affine(weights, "out", (share @ x).reshape(-1, self.width))

    def _attend(self, ops: Ops, weights: Weights, at: str, x: Array, count: int, hidden: Array | None) -> Array:
        each = self.width // self.heads
        normed = _normed(weights, f"{at}.attend", x)
        query, key, value = (
            affine(weights, f"{at}.{name}", normed).reshape(-1, count, self.heads, each).swapaxes(1, 2)
            for name in ("query", "key", "value")
        )
        paid = query @ key.swapaxes(2, 3) * each**-0.5
        if hidden is not None:
            paid = paid + hidden.reshape(-1, 1, 1, count)
        told = (ops.softmax(paid) @ value).swapaxes(1, 2).reshape(-1, count, self.width)
        return affine(weights, f"{at}.attended", told)


def _tokens(part: Part) -> dict[str, tuple[int, int]]:
    """Name of each kind of token of a modality -> how many there are, and of how many numbers."""
    if part.kind == "vector":
        return {f"{part.name}.whole": (1, part.shape[0])}
    if part.kind == "series":
        steps, channels = part.shape
        window = largest_divisor(steps, WINDOW)
        return {
            f"{part.name}.channel": (channels, steps),
            f"{part.name}.window": (steps // window, window * channels),
        }
    channels, rows, columns = part.shape
    down, across = largest_divisor(rows, GRID), largest_divisor(columns, GRID)
    return {f"{part.name}.patch": (down * across, channels * rows * columns // (down * across))}


def _cut(part: Part, name: str, x: Array) -> Array:
    """(n, *shape) -> (n, tokens, numbers)."""
    count, numbers = _tokens(part)[name]
    if part.kind == "image":
        _, rows, columns = part.shape
        return patches(x, part.shape, rows // largest_divisor(rows, GRID), columns // largest_divisor(columns, GRID))
    if name.endswith(".channel"):
        return x.swapaxes(1, 2)
    return x.reshape(-1, count, numbers)


def _norm(name: str, width: int) -> dict[str, Start]:
    return {f"{name}.gain": Start((width,), centre=1.0), f"{name}.shift": Start((width,))}


def _normed(weights: Weights, name: str, x: Array) -> Array:
    """Layer normalisation."""
    centred = x - x.mean(axis=-1, keepdims=True)
    spread = ((centred * centred).mean(axis=-1, keepdims=True) + EPSILON) ** 0.5
    return centred / spread * weights[f"{name}.gain"] + weights[f"{name}.shift"]
