"""Learn a net's weights: cross-entropy, modalities dropped at random, the epoch chosen on folds that are held back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, pi
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional

from fusion.neural.layout import FloatArray, Layout
from fusion.neural.net import Net, start_weights
from fusion.neural.ops import TorchOps
from fusion.neural.scaling import Scale

WARM_UP = 0.1  # of the epochs, at a rising rate
GRADIENT_LIMIT = 1.0
BATCH_OF_CHECKS = 256

Rows = NDArray[np.int64]
Arrays = dict[str, NDArray[np.float32]]


@dataclass(frozen=True)
class Schedule:
    """How a net is learnt; the names are those of the estimators' parameters."""

    epochs: int
    batch_size: int
    learning_rate: float
    weight_decay: float
    noise: float
    label_smoothing: float
    modality_dropout: float

    def rate(self, progress: float) -> float:
        """Learning rate at a part (0 to 1) of all epochs: up along a line, then down along a cosine."""
        if progress < WARM_UP:
            return self.learning_rate * (progress / WARM_UP)
        return self.learning_rate * 0.5 * (1.0 + cos(pi * (progress - WARM_UP) / (1.0 - WARM_UP)))


@dataclass(frozen=True, eq=False)
class Learnt:
    """Weights and scales of a net, and its loss on held-back rows after every epoch (empty without any)."""

    weights: dict[str, FloatArray]
    scales: dict[str, Scale]
    held_back_loss: FloatArray


def learn(
    net: Net,
    data: FloatArray,
    target: Rows,
    schedule: Schedule,
    *,
    rng: np.random.Generator,
    device: str,
    stop: int | None = None,
    held_back: tuple[FloatArray, Rows] | None = None,
) -> Learnt:
    """Learn from rows of X (n, columns) with class indices (n,); `stop` ends after that many epochs of the schedule.

    The same generator, data and kind of device give the same weights: torch draws no random number here, and on the
    CPU it works on one thread. ValueError where learning diverges.
    """
    layout = net.layout
    scales = {part.name: Scale.of(part, part.of(data)) for part in layout.parts}
    rows = _scaled(layout, scales, data)
    place = torch_device(device)
    weights = {
        name: torch.from_numpy(values).to(place).requires_grad_() for name, values in start_weights(net, rng).items()
    }
    matrices = [weight for weight in weights.values() if weight.ndim > 1]
    vectors = [weight for weight in weights.values() if weight.ndim == 1]
    parameters: list[dict[str, Any]] = [{"params": matrices}, {"params": vectors, "weight_decay": 0.0}]
    optimizer = torch.optim.AdamW(parameters, weight_decay=schedule.weight_decay)
    inputs = {name: torch.from_numpy(values).to(place) for name, values in rows.items()}
    labels = torch.from_numpy(target).to(place)
    checks = None if held_back is None else (_scaled(layout, scales, held_back[0]), held_back[1])
    batches = -(-len(target) // schedule.batch_size)
    losses = []
    for epoch in range(schedule.epochs if stop is None else stop):
        for number, chosen in enumerate(np.array_split(rng.permutation(len(target)), batches)):
            for group in optimizer.param_groups:
                group["lr"] = schedule.rate((epoch + (number + 0.5) / batches) / schedule.epochs)
            present = drop_modalities(len(chosen), len(layout.parts), schedule.modality_dropout, rng)
            _step(net, weights, optimizer, inputs, labels, chosen, present, schedule, rng)
        if checks is not None:
            losses.append(_loss(net, weights, *checks, place))
    _check_learnt(weights, [*losses, _loss(net, weights, rows, target, place)], schedule)
    kept = {name: weight.detach().cpu().numpy().astype(np.float64) for name, weight in weights.items()}
    return Learnt(kept, scales, np.array(losses))


def drop_modalities(n: int, modalities: int, share: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """(n, modalities) 1 or 0: a `share` of the rows loses some modalities, one at least is left."""
    present = np.ones((n, modalities), np.float32)
    if modalities > 1 and share > 0:
        kept = rng.integers(1, modalities, n)
        order = rng.random((n, modalities)).argsort(axis=1).argsort(axis=1)
        dropped = (order >= kept[:, None]) & (rng.random(n) < share)[:, None]
        present[dropped] = 0.0
    return present


def torch_device(device: str) -> torch.device:
    """The torch device of that name; ValueError where it is unknown or not there."""
    kind = device.partition(":")[0] if isinstance(device, str) else ""
    if kind not in ("cpu", "cuda"):
        raise ValueError(f"device must be 'cpu' or 'cuda', got {device!r}.")
    if kind == "cuda" and not torch.cuda.is_available():
        raise ValueError("device='cuda': torch sees no CUDA device here; take device='cpu'.")
    return torch.device(device)


def _scaled(layout: Layout, scales: Mapping[str, Scale], data: FloatArray) -> Arrays:
    return {part.name: scales[part.name].apply(part.of(data)).astype(np.float32) for part in layout.parts}


def _step(
    net: Net,
    weights: Mapping[str, Any],
    optimizer: torch.optim.Optimizer,
    inputs: Mapping[str, torch.Tensor],
    labels: torch.Tensor,
    chosen: Rows,
    present: NDArray[np.float32],
    schedule: Schedule,
    rng: np.random.Generator,
) -> None:
    place = labels.device
    rows = torch.from_numpy(chosen).to(place)
    parts = {}
    for name, values in inputs.items():
        parts[name] = values[rows]
        if schedule.noise > 0:
            noise = rng.standard_normal(parts[name].shape, dtype=np.float32)
            parts[name] = parts[name] + schedule.noise * torch.from_numpy(noise).to(place)
    there = None if present.all() else torch.from_numpy(present).to(place)
    logits = net.logits(TorchOps(), weights, parts, there)
    loss = functional.cross_entropy(logits, labels[rows], label_smoothing=schedule.label_smoothing)
    optimizer.zero_grad()
    loss.backward()  # type: ignore[no-untyped-call]
    torch.nn.utils.clip_grad_norm_(list(weights.values()), GRADIENT_LIMIT)
    optimizer.step()


def _check_learnt(weights: Mapping[str, torch.Tensor], losses: list[float], schedule: Schedule) -> None:
    """ValueError where a weight or one of the losses is not finite."""
    if not (np.isfinite(losses).all() and all(bool(torch.isfinite(weight).all()) for weight in weights.values())):
        raise ValueError(
            f"learning diverged: loss or weights are not finite at learning_rate={schedule.learning_rate!r}, "
            f"weight_decay={schedule.weight_decay!r}; lower them."
        )


def _loss(net: Net, weights: Mapping[str, Any], data: Arrays, target: Rows, place: torch.device) -> float:
    """Mean cross-entropy with every modality there."""
    total = 0.0
    with torch.no_grad():
        for start in range(0, len(target), BATCH_OF_CHECKS):
            rows = slice(start, start + BATCH_OF_CHECKS)
            parts = {name: torch.from_numpy(values[rows]).to(place) for name, values in data.items()}
            labels = torch.from_numpy(target[rows]).to(place)
            total += float(functional.cross_entropy(net.logits(TorchOps(), weights, parts), labels, reduction="sum"))
    return total / len(target)
