"""CPU time of one frame through each backbone, interleaved, so that ratios hold on a busy machine too."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from fusion.features.backbone import Backbone


@dataclass(frozen=True)
class FrameCost:
    """Milliseconds of CPU of one frame on one thread; `random` weights serve for speed alone."""

    backbone: str
    weights: Literal["pretrained", "random"]
    features: int
    model_mb: float
    licence: str
    ms_min: float
    ms_p50: float
    ms_p95: float
    times_faster_than_vgg16: float
    frames: int


def frame_costs(names: Sequence[str], frames: int = 20, *, warm_up: int = 2) -> list[FrameCost]:
    """Costs of 256 x 256 frames through ONNX Runtime on one thread, all backbones in turn for every frame.

    VGG-16 always takes part, and always with random weights: they cost what the published ones do and need no network.
    The ratio to it is of medians.
    """
    from fusion.features import get_backbone

    backbones = {name: get_backbone(name, weights=_weights(name)) for name in dict.fromkeys([*names, "vgg16"])}
    images = np.random.default_rng(0).integers(60, 120, (frames + warm_up, 256, 256, 3), dtype=np.uint8)
    spent = _interleaved(backbones, images)
    kept = {name: np.array(values[warm_up:]) for name, values in spent.items()}
    slowest = float(np.median(kept["vgg16"]))
    return [
        FrameCost(
            backbone.name,
            _weights(name),
            backbone.dim,
            _model_mb(backbone),
            backbone.licence if _weights(name) == "pretrained" else "BSD-3-Clause",
            float(kept[name].min()),
            float(np.median(kept[name])),
            float(np.percentile(kept[name], 95)),
            slowest / float(np.median(kept[name])),
            frames,
        )
        for name, backbone in backbones.items()
    ]


def _interleaved(backbones: Mapping[str, Backbone], images: NDArray[np.uint8]) -> dict[str, list[float]]:
    """Milliseconds of CPU by backbone and frame; the order of the backbones turns from frame to frame."""
    spent: dict[str, list[float]] = {name: [] for name in backbones}
    names = list(backbones)
    for number, image in enumerate(images):
        first = number % len(names)
        for name in names[first:] + names[:first]:
            start = time.process_time_ns()
            backbones[name].extract(image[None])
            spent[name].append((time.process_time_ns() - start) / 1e6)
    return spent


def _weights(name: str) -> Literal["pretrained", "random"]:
    return "random" if name == "vgg16" else "pretrained"


def _model_mb(backbone: Backbone) -> float:
    """Size of the graph that runs."""
    return len(backbone.onnx_model().SerializeToString()) / 1e6
