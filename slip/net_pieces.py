"""Trials cut into pieces of equal length to learn from, each with what its first sample looks back on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from slip.net import KERNEL, compress
from slip.samples import Floats
from slip.training_trial import GROSS, PARTIAL, Integers, latest_frame

PIECE = 1_000  # samples
Partial = Literal["ignore", "stick", "slip"]


@dataclass(frozen=True)
class Prepared:
    """One trial as the net sees it: treated differences (T, taxels), where it sticks, targets and their weights (T,),
    the changes of its frames (F, grid, grid, 3) and the samples (F,) that they come at.
    """

    differences: Floats
    stick: NDArray[np.bool_]
    target: NDArray[np.float32]
    weight: NDArray[np.float32]
    change: Floats | None
    frame_samples: Integers


@dataclass(frozen=True)
class Pieces:
    """Pieces (N, L, ...) ready for torch; weight 0 where a sample only gives context or is padding.

    change : (N, F, grid, grid, 3) compressed or None; latest : (N, L) frames of the piece that are there.
    """

    differences: NDArray[np.float32]
    target: NDArray[np.float32]
    weight: NDArray[np.float32]
    change: NDArray[np.float32] | None
    latest: Integers


def labels(state: Integers, partial: Partial) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Target 1 for slip and 0 for stick, weight 0 where partial slip is ignored; (T,) each."""
    slipping = state >= PARTIAL if partial == "slip" else state == GROSS
    told = state != PARTIAL if partial == "ignore" else np.ones(len(state), dtype=np.bool_)
    return slipping.astype(np.float32), told.astype(np.float32)


def cut_pieces(trials: Sequence[Prepared], reach: int, scale: Floats, frame_scale: float) -> Pieces:
    """Cut every trial into pieces of 1000 samples with the `reach` samples before them as context.

    A trial's first piece is padded at its end instead, as the stream starts on zeros there.
    """
    length = reach + PIECE
    spans = [
        (trial, max(first - reach, 0), first, min(first + PIECE, len(trial.target)))
        for trial in trials
        for first in range(0, len(trial.target), PIECE)
    ]
    count, taxels = len(spans), trials[0].differences.shape[1]
    differences = np.zeros((count, length, taxels), dtype=np.float32)
    target, weight = np.zeros((count, length), dtype=np.float32), np.zeros((count, length), dtype=np.float32)
    latest = np.zeros((count, length), dtype=np.int64)
    films: list[Floats] = []
    for i, (trial, start, first, stop) in enumerate(spans):
        differences[i, : stop - start] = compress(trial.differences[start:stop] / scale)
        target[i, first - start : stop - start] = trial.target[first:stop]
        weight[i, first - start : stop - start] = trial.weight[first:stop]
        if trial.change is not None:
            there = latest_frame(trial.frame_samples, stop)[start:]
            # Frames from the one held at `start` on, and the two before it that its embedding is made of.
            skipped = max(int(there[0]) - KERNEL, 0)
            latest[i, : stop - start] = there - skipped
            films.append(compress(trial.change[skipped : int(there[-1])] / frame_scale))
    return Pieces(differences, target, weight, _stack(films), latest)


def _stack(films: Sequence[Floats]) -> NDArray[np.float32] | None:
    if not films:
        return None
    stacked = np.zeros((len(films), max(1, *(len(film) for film in films)), *films[0].shape[1:]), dtype=np.float32)
    for i, film in enumerate(films):
        stacked[i, : len(film)] = film
    return stacked
