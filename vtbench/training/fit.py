"""Training of `vt-vgg`: batches of presses, both as frames and as changes; the checkpoint is chosen on validation."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from vtbench.run.progress import bar
from vtbench.training.evidence import Evidence, evidence
from vtbench.training.network import VTVGG, Objective, Trainee, levels_of
from vtbench.training.presses import Arrays, pooled

BATCH = 32
PEAK_RATE = 2e-3
WEIGHT_DECAY = 0.05
_GAIN_SPREAD = 0.06
_NOISE = 0.15
"""Grey levels of the mean of a square; half a camera's."""


@dataclass(frozen=True)
class Fitted:
    """A trained network: weights of the best epoch, counted from 0, its evidence, and the loss of every epoch."""

    weights: dict[str, NDArray[np.float32]]
    best_epoch: int
    evidence: Evidence
    losses: tuple[float, ...]
    seconds: float


def fit(
    presses: Arrays,
    validation: Arrays,
    objective: Objective,
    *,
    epochs: int,
    seed: int,
    device: str = "cpu",
    progress: bool = False,
    report: Callable[[int, float, Evidence], None] = lambda epoch, loss, found: None,
) -> Fitted:
    """Train on presses; of the later half of the epochs, the best on the validation presses gives the weights.

    ValueError for a device that is not there.
    """
    check_device(device)
    started = time.perf_counter()
    torch.manual_seed(seed)
    rng = np.random.default_rng([seed, 5])
    n = len(presses["shape"])
    trainee = Trainee(objective, int(presses["shape"].max()) + 1).to(device)
    trainee.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    groups = [
        {"params": [p for p in trainee.parameters() if p.ndim > 1], "weight_decay": WEIGHT_DECAY},
        {"params": [p for p in trainee.parameters() if p.ndim <= 1], "weight_decay": 0.0},
    ]
    optimiser = torch.optim.AdamW(groups, lr=PEAK_RATE)
    steps = epochs * (n // BATCH)
    schedule = torch.optim.lr_scheduler.LambdaLR(optimiser, lambda step: _rate(step, steps))
    targets = standardised_maps(presses)
    changes, frames = (_validation_sums(validation, name) for name in ("change", "frame"))
    found: dict[int, Evidence] = {}
    losses: list[float] = []
    weights: dict[str, NDArray[np.float32]] = {}
    with bar(steps, "training", progress) as advance:
        for epoch in range(epochs):
            trainee.train()
            total = 0.0
            order = rng.permutation(n)[: n // BATCH * BATCH].reshape(-1, BATCH)
            for rows in order:
                batch = np.concatenate([presses["frame"][rows], presses["change"][rows]])
                levels = _varied(levels_of(batch), rng).to(device)
                maps = torch.from_numpy(targets[rows]).to(device).repeat(2, 1)
                shape = torch.from_numpy(presses["shape"][rows].astype(np.int64)).to(device).repeat(2)
                with torch.autocast(device, torch.bfloat16, enabled=reduced_precision(device)):
                    loss = trainee.loss(levels, maps, shape)
                optimiser.zero_grad(set_to_none=True)
                loss.backward()  # type: ignore[no-untyped-call]
                torch.nn.utils.clip_grad_norm_(trainee.parameters(), 1.0)
                optimiser.step()
                schedule.step()
                total += float(loss.detach())
                advance(1)
            losses.append(total / len(order))
            if epoch < epochs // 2:
                continue
            network = trainee.network
            found[epoch] = evidence(features(network, changes, device), features(network, frames, device), validation)
            report(epoch, losses[-1], found[epoch])
            if found[epoch].mean >= max(other.mean for other in found.values()):
                weights = network.arrays()
    best = max(found, key=lambda epoch: (found[epoch].mean, epoch))
    return Fitted(weights, best, found[best], tuple(losses), time.perf_counter() - started)


def features(network: VTVGG, sums: NDArray[np.uint16], device: str) -> NDArray[np.float32]:
    """Features (n, 512) in evaluation mode, in float32."""
    network.eval()
    with torch.inference_mode():
        parts = [
            network(levels_of(part).to(device)).cpu().numpy()
            for part in np.array_split(sums, -(-len(sums) // (2 * BATCH)))
        ]
    return np.concatenate(parts)


def standardised_maps(presses: Arrays) -> NDArray[np.float32]:
    """Targets (n, 2048): root of the pressure and displacement, each over its root mean square."""
    parts = []
    for name, power in (("pressure", 0.5), ("displacement", 1.0)):
        values = np.maximum(presses[name].astype(np.float32), 0).reshape(len(presses[name]), -1) ** power
        parts.append(values / np.sqrt(np.mean(values**2)))
    return np.concatenate(parts, axis=1)


def check_device(device: str) -> None:
    """ValueError unless torch can compute there; `cpu` and `cuda` are known."""
    if device == "cpu":
        return
    if device != "cuda":
        raise ValueError(f"device: expected cpu or cuda, got {device!r}")
    if not torch.cuda.is_available():
        raise ValueError("device: cuda was asked for, but this torch finds no CUDA device; use --device cpu")


def reduced_precision(device: str) -> bool:
    """Whether matrix products of training run in bfloat16: where the processor computes in it."""
    return device == "cuda" or bool(torch.cpu._is_avx512_bf16_supported())


def _rate(step: int, steps: int) -> float:
    """One cycle: a linear rise over a tenth of the steps, then a cosine to nothing."""
    rise = max(1, steps // 10)
    return (step + 1) / rise if step < rise else 0.5 + 0.5 * math.cos(math.pi * (step - rise) / max(1, steps - rise))


def _varied(levels: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """Brightness of each colour varied from image to image, and noise of the camera."""
    gains = torch.from_numpy(1 + _GAIN_SPREAD * rng.standard_normal((len(levels), 3, 1, 1), dtype=np.float32))
    noise = torch.from_numpy(_NOISE * rng.standard_normal(tuple(levels.shape), dtype=np.float32))
    return (levels * gains + noise).clamp(0, 255)


def _validation_sums(validation: Arrays, name: str) -> NDArray[np.uint16]:
    return np.stack([pooled(image) for image in validation[name]])
