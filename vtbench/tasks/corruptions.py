"""What may go wrong with a tactile array or its camera, at stated levels, drawn for each sample from its id."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from vtbench.tasks.base import Features

VERSION = 1
"""Raised when what a level does changes: part of the name under which features are kept."""

Frame = NDArray[np.uint8]


@dataclass(frozen=True)
class ForceFault:
    """A fault of the array; `apply` takes forces (..., taxels) of a press in newtons, and spoils all steps alike."""

    about: str
    apply: Callable[[Features, Generator], Features]


@dataclass(frozen=True)
class FrameFault:
    """A fault of the camera; `apply` takes frame and rest frame, each (H, W, 3) uint8. The rest frame stays whole."""

    about: str
    apply: Callable[[Frame, Frame, Generator], Frame]


def dead(count: int, force: Features, rng: Generator) -> Features:
    """`count` taxels at random read 0 N; all of them where there are no more."""
    out = force.copy()
    out[..., rng.permutation(force.shape[-1])[:count]] = 0
    return out


def gain_drift(spread: float, force: Features, rng: Generator) -> Features:
    """Each taxel's gain is off by a normal factor of relative standard deviation `spread`."""
    return force * rng.normal(1, spread, force.shape[-1:]).astype(np.float32)


def force_noise(deviation_n: float, force: Features, rng: Generator) -> Features:
    """Normal noise of `deviation_n` newtons on each taxel of the averaged reading; on a history, a constant error."""
    return force + rng.normal(0, deviation_n, force.shape[-1:]).astype(np.float32)


def frame_noise(levels: float, frame: Frame, rest: Frame, rng: Generator) -> Frame:
    """Normal noise of `levels` grey levels on each channel of each pixel."""
    return _levels(frame + rng.standard_normal(frame.shape, np.float32) * levels)


def lighting(share: float, frame: Frame, rest: Frame, rng: Generator) -> Frame:
    """Each of the three lights is off by a factor drawn uniformly within 1 +- `share`: brightness and tint."""
    return _levels(frame * rng.uniform(1 - share, 1 + share, 3).astype(np.float32))


def blur(deviation_px: float, frame: Frame, rest: Frame, rng: Generator) -> Frame:
    """Gaussian blur of standard deviation `deviation_px` pixels."""
    import cv2

    return np.asarray(cv2.GaussianBlur(frame, (0, 0), deviation_px), np.uint8)


def black(frame: Frame, rest: Frame, rng: Generator) -> Frame:
    """The camera gives a black frame."""
    return np.zeros_like(frame)


def frozen(frame: Frame, rest: Frame, rng: Generator) -> Frame:
    """The camera still gives the frame before contact."""
    return rest.copy()


FORCE_FAULTS: Mapping[str, ForceFault] = {
    **{f"dead-{n}": ForceFault(f"{n} dead taxels", partial(dead, n)) for n in (1, 2, 4, 8)},
    **{f"gain-{p}pct": ForceFault(f"gains drift by {p} %", partial(gain_drift, p / 100)) for p in (5, 10, 20, 40)},
    **{f"noise-{n}N": ForceFault(f"noise of {n} N a taxel", partial(force_noise, n)) for n in (0.1, 0.2, 0.5)},
}
FRAME_FAULTS: Mapping[str, FrameFault] = {
    **{f"grain-{n}": FrameFault(f"noise of {n} grey levels", partial(frame_noise, n)) for n in (1, 3, 10)},
    **{f"light-{p}pct": FrameFault(f"lights off by up to {p} %", partial(lighting, p / 100)) for p in (5, 10, 20)},
    **{f"blur-{n}px": FrameFault(f"blur of {n} pixels", partial(blur, n)) for n in (0.5, 1, 2)},
    "camera-black": FrameFault("black frames", black),
    "camera-frozen": FrameFault("frames from before contact", frozen),
}


def drawn_for(sample: str, fault: str) -> Generator:
    """Random numbers of one fault on one sample: the same in whichever order samples come."""
    return np.random.default_rng([zlib.crc32(sample.encode()), zlib.crc32(fault.encode())])


def faulty_forces(fault: str, force: Features, ids: Sequence[str]) -> Features:
    """Forces (n, taxels), or histories (n, steps, taxels), with one of `FORCE_FAULTS`: the same one in either."""
    apply = FORCE_FAULTS[fault].apply
    return np.array([apply(f, drawn_for(i, fault)) for f, i in zip(force, ids, strict=True)], np.float32)


def faulty_frames(fault: str, frames: Frame, rest: Frame, ids: Sequence[str]) -> Frame:
    """Frames (n, H, W, 3) with one of `FRAME_FAULTS`; `rest` are the frames before contact."""
    apply = FRAME_FAULTS[fault].apply
    return np.stack([apply(f, r, drawn_for(i, fault)) for f, r, i in zip(frames, rest, ids, strict=True)])


def _levels(values: NDArray[Any]) -> Frame:
    return np.asarray(np.clip(np.rint(values), 0, 255), np.uint8)
