"""Learn a net's weights: cross-entropy on labelled samples, the checkpoint taken where other trials fare best."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from slip.net import NetShape
from slip.net_pieces import Pieces
from slip.net_torch import TorchNet
from slip.samples import Floats

CAMERA_OFF = 0.25  # share of the pieces learnt without camera, so that the forces are learnt from too
GRADIENT_LIMIT = 1.0


@dataclass(frozen=True)
class Epoch:
    """Mean losses after one epoch; stick and slip weigh the same in both."""

    training: float
    validation: float


@dataclass(frozen=True)
class Schedule:
    """How long and how fast to learn; `batch` is in pieces of 1000 samples."""

    epochs: int = 30
    batch: int = 8
    learning_rate: float = 8e-3
    weight_decay: float = 1e-3

    def __post_init__(self) -> None:
        if self.epochs < 1 or self.batch < 1 or not (self.learning_rate > 0.0 and self.weight_decay >= 0.0):
            raise ValueError(f"expected at least 1 epoch, pieces of a batch and a positive learning rate, got {self}")


def learn(
    shape: NetShape,
    training: Pieces,
    validation: Pieces,
    schedule: Schedule,
    *,
    seed: int,
    device: str,
    progress: bool,
) -> tuple[dict[str, Floats], list[Epoch], int]:
    """Return the weights of the epoch with the least validation loss, every epoch's losses, and that epoch.

    The same seed, data and kind of device give the same weights on one thread. Torch's own random state is left
    as it was. Raises ValueError for a device that is not there.
    """
    place = torch_device(device)
    rng = np.random.default_rng(seed)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        net = TorchNet(shape).to(place)
    optimizer = torch.optim.AdamW(net.parameters(), schedule.learning_rate, weight_decay=schedule.weight_decay)
    batches = -(-len(training.target) // schedule.batch)
    rate = torch.optim.lr_scheduler.OneCycleLR(
        optimizer, schedule.learning_rate, total_steps=schedule.epochs * batches + 1
    )
    history: list[Epoch] = []
    best: dict[str, Floats] = {}
    chosen = 0
    balance = _balance(training)
    for epoch in _with_progress(schedule.epochs, progress):
        losses = []
        for rows in np.array_split(rng.permutation(len(training.target)), batches):
            camera = (rng.uniform(size=len(rows)) >= CAMERA_OFF).astype(np.float32)
            loss, weight = _loss(net, training, rows, camera, balance, place)
            optimizer.zero_grad()
            (loss / weight).backward()  # type: ignore[no-untyped-call]
            torch.nn.utils.clip_grad_norm_(net.parameters(), GRADIENT_LIMIT)
            optimizer.step()
            rate.step()
            losses.append((float(loss.detach()), float(weight)))
        total, weights = np.sum(losses, axis=0)
        history.append(Epoch(float(total / weights), _evaluate(net, validation, schedule.batch, place)))
        if not best or history[-1].validation < history[chosen].validation:
            best, chosen = net.weights(), epoch
    return best, history, chosen


def torch_device(device: str) -> torch.device:
    """The torch device of that name. Raises ValueError where it is unknown or not there."""
    kind = device.partition(":")[0]
    if kind not in ("cpu", "cuda"):
        raise ValueError(f'expected device to be "cpu" or "cuda", got {device!r}')
    if kind == "cuda" and not torch.cuda.is_available():
        raise ValueError('expected a CUDA device for device="cuda", but torch sees none: take device="cpu"')
    return torch.device(device)


def _balance(pieces: Pieces) -> tuple[float, float]:
    """Weights of a stick and of a slip sample that make both kinds weigh the same."""
    slip = float((pieces.weight * pieces.target).sum(dtype=np.float64))
    stick = float(pieces.weight.sum(dtype=np.float64)) - slip
    if not (slip > 0.0 and stick > 0.0):
        raise ValueError(f"expected labelled samples of stick and of slip, got {stick:.0f} and {slip:.0f}")
    return 0.5 * (slip + stick) / stick, 0.5 * (slip + stick) / slip


def _loss(
    net: TorchNet, pieces: Pieces, rows: Any, camera: Any, balance: tuple[float, float], place: torch.device
) -> tuple[Tensor, Tensor]:
    """Weighted sum of the cross-entropies of some pieces, and the sum of the weights."""
    differences, target, weight, latest, seen = (
        torch.from_numpy(each).to(place)
        for each in (pieces.differences[rows], pieces.target[rows], pieces.weight[rows], pieces.latest[rows], camera)
    )
    change = None if pieces.change is None else torch.from_numpy(pieces.change[rows]).to(place)
    logits = net(differences, change, latest, seen)
    weight = weight * torch.where(target > 0.5, balance[1], balance[0])
    each = functional.binary_cross_entropy_with_logits(logits, target, reduction="none")
    return (each * weight).sum(), weight.sum().clamp_min(1e-9)


def _evaluate(net: TorchNet, pieces: Pieces, batch: int, place: torch.device) -> float:
    balance = _balance(pieces)
    total = weights = 0.0
    with torch.no_grad():
        for first in range(0, len(pieces.target), batch):
            rows = np.arange(first, min(first + batch, len(pieces.target)))
            loss, weight = _loss(net, pieces, rows, np.ones(len(rows), dtype=np.float32), balance, place)
            total, weights = total + float(loss), weights + float(weight)
    return total / weights


def _with_progress(epochs: int, progress: bool) -> Any:
    if not progress:
        return range(epochs)
    from tqdm import tqdm

    return tqdm(range(epochs), desc="slip net", unit="epoch")
