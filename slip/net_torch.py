"""The net of `slip.net` as a torch module, to learn its weights."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from slip.net import KERNEL, NetShape
from slip.samples import Floats


class TorchNet(nn.Module):
    """Same layers and names of weights as `slip.net.Net`; gives logits of batches of pieces."""

    def __init__(self, shape: NetShape) -> None:
        super().__init__()
        self.shape = shape
        sizes = shape.weights()
        self.linear = nn.ModuleDict(
            {name: nn.Linear(size[0], size[1]) for name, size in sizes.items() if not name.endswith(".bias")}
        )
        with torch.no_grad():
            for name, layer in self.linear.items():
                assert isinstance(layer, nn.Linear)
                nn.init.kaiming_uniform_(layer.weight, nonlinearity="linear" if name == "slip" else "relu")
                nn.init.zeros_(layer.bias)
                if name.startswith("conv") and name != "conv0":
                    layer.weight *= 0.5  # the sum over the levels starts out tame

    def forward(self, differences: Tensor, change: Tensor | None, latest: Tensor, camera: Tensor) -> Tensor:
        """Logits (N, T).

        differences (N, T, taxels) and change (N, F, grid, grid, 3), both compressed; latest (N, T) frames there at
        each sample, of the piece's own; camera (N,) 1, or 0 where the camera is taken away.
        """
        x = differences.transpose(1, 2)
        for level in range(self.shape.levels):
            out = functional.relu(self._convolve(x, f"conv{level}", 1 << level))
            x = x + out if level else out
        joined = x.transpose(1, 2)
        if self.shape.embedding and change is not None:
            told = self._embed(change) * camera[:, None, None]
            held = torch.gather(told, 1, latest[..., None].expand(-1, -1, self.shape.embedding))
            joined = torch.cat([joined, held], dim=2)
        logits: Tensor = self.linear["slip"](functional.relu(self.linear["hidden"](joined)))
        return logits[..., 0]

    def _convolve(self, x: Tensor, name: str, dilation: int) -> Tensor:
        layer = self.linear[name]
        assert isinstance(layer, nn.Linear)
        weight = layer.weight.reshape(layer.out_features, KERNEL, x.shape[1]).transpose(1, 2)
        padded = functional.pad(x, ((KERNEL - 1) * dilation, 0))
        return functional.conv1d(padded, weight, layer.bias, dilation=dilation)

    def _embed(self, change: Tensor) -> Tensor:
        """Embeddings (N, 1 + F, embedding), the first for the time before any frame."""
        pieces, frames, grid, _, _ = change.shape
        side, patch = grid // self.shape.patch, self.shape.patch
        cut = change.reshape(pieces, frames, side, patch, side, patch, 3).permute(0, 1, 2, 4, 3, 5, 6)
        cut = cut.reshape(pieces, frames, side * side, patch * patch * 3)
        told = functional.relu(self.linear["patch"](cut)).reshape(pieces, frames, -1)
        motion = functional.relu(self._convolve(told.transpose(1, 2), "motion", 1))
        return functional.pad(motion, (1, 0)).transpose(1, 2)

    def weights(self) -> dict[str, Floats]:
        """The weights as `slip.net.Net` takes them."""
        found: dict[str, Floats] = {}
        for name, layer in self.linear.items():
            assert isinstance(layer, nn.Linear)
            found[name] = layer.weight.detach().cpu().numpy().T.astype(np.float64)
            found[f"{name}.bias"] = layer.bias.detach().cpu().numpy().astype(np.float64)
        return found
