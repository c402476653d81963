"""The network of `vt-vgg` in torch, with the heads that only training needs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from fusion.features.vt_vgg import BATCH_NORM_EPSILON, DIM, GAIN, WIDTHS
from vtbench.training.presses import MAP_SIDE, POOL

Pooling = Literal["mean", "weighted"]
_LAST_SIDE = 8


@dataclass(frozen=True)
class Objective:
    """What the features are trained for, and how the last map is pooled.

    Attributes:
        pooling: plain mean, or a learnt weight for every channel and place.
        maps: weight of predicting the true pressure and displacement of the skin, linearly from the features.
        shapes: weight of naming the training shape.
    """

    pooling: Pooling = "weighted"
    maps: float = 1.0
    shapes: float = 0.1


class _Layer(nn.Module):
    """Convolution, batch normalisation, ReLU."""

    def __init__(self, inside: int, outside: int, kernel: int) -> None:
        super().__init__()
        self.conv = nn.Conv2d(inside, outside, kernel, padding=kernel // 2, bias=False)
        self.norm = nn.BatchNorm2d(outside, BATCH_NORM_EPSILON)

    def forward(self, x: Tensor) -> Tensor:
        """(N, inside, H, W) to (N, outside, H, W)."""
        return functional.relu(self.norm(self.conv(x)))


class VTVGG(nn.Module):
    """Frames as sums over squares (N, 3, 64, 64) to features (N, 512)."""

    def __init__(self, pooling: Pooling) -> None:
        super().__init__()
        stages, width = [], 3
        for widths in WIDTHS:
            stages.append(nn.Sequential(*(_Layer(a, b, 3) for a, b in zip((width, *widths), widths, strict=False))))
            width = widths[-1]
        self.stages = nn.ModuleList(stages)
        self.head = _Layer(width, DIM, 1)
        self.pool: nn.Module = nn.AdaptiveAvgPool2d(1)
        if pooling == "weighted":
            self.pool = nn.Conv2d(DIM, DIM, _LAST_SIDE, groups=DIM, bias=False)
            nn.init.normal_(self.pool.weight, 0.0, 1.0 / _LAST_SIDE)

    def forward(self, levels: Tensor) -> Tensor:
        """Features of mean grey levels (N, 3, 64, 64), 0 to 255."""
        x = torch.log(levels + 1)
        x = GAIN * (x - x.mean(dim=(2, 3), keepdim=True))
        x = x.contiguous(memory_format=torch.channels_last)
        for s, stage in enumerate(self.stages):
            x = stage(functional.max_pool2d(x, 2) if s else x)
        return self.pool(self.head(x)).flatten(1)

    def arrays(self) -> dict[str, NDArray[np.float32]]:
        """The weights by name, as `fusion.features.vt_vgg.build` takes them."""
        return {name: value.detach().float().cpu().numpy() for name, value in self.state_dict().items()}


class Trainee(nn.Module):
    """The network with its heads: linear maps of the skin's state, cosine scores of the training shapes."""

    def __init__(self, objective: Objective, shapes: int) -> None:
        super().__init__()
        self.objective = objective
        self.network = VTVGG(objective.pooling)
        self.norm = nn.BatchNorm1d(DIM)
        self.maps = nn.Linear(DIM, 2 * MAP_SIDE**2)
        self.shapes = nn.Linear(DIM, shapes, bias=False)

    def loss(self, levels: Tensor, maps: Tensor, shape: Tensor) -> Tensor:
        """Scalar loss of frames (N, 3, 64, 64), standardised maps (N, 2048) and shape numbers (N,)."""
        features = self.norm(self.network(levels).float())
        total = features.new_zeros(())
        if self.objective.maps:
            total = total + self.objective.maps * functional.mse_loss(self.maps(features), maps)
        if self.objective.shapes:
            scores = functional.normalize(features) @ functional.normalize(self.shapes.weight).T
            total = total + self.objective.shapes * functional.cross_entropy(12 * scores, shape)
        return total


def levels_of(sums: NDArray[np.generic]) -> Tensor:
    """Mean grey levels (N, 3, 64, 64) float32 of sums over squares."""
    return torch.from_numpy(np.asarray(sums, np.float32)) / POOL**2
