"""From labelled trials to a trained net: who is held back, what counts as noise, then `slip.net_training`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from slip.net import Net, NetShape
from slip.net_camera import changes, downsample
from slip.net_pieces import Partial, Prepared, cut_pieces, labels
from slip.rest_noise import measure_rest
from slip.samples import Floats
from slip.training_trial import STICK, TrainingTrial

if TYPE_CHECKING:
    from slip.net_training import Epoch, Schedule

HELD_BACK = 5  # every fifth trial
NOISE_BLOCK = 100  # samples
NOISE_QUANTILE = 0.25  # of the blocks: most are at rest, some hold a change of load


@dataclass(frozen=True)
class Fitted:
    """A trained net, the scale of its differences, the losses of every epoch and the one that was kept."""

    net: Net
    scale: Floats
    history: list[Epoch]
    epoch: int


def fit_net(
    sizes: NetShape,
    differences: Callable[[Floats], Floats],
    scale: Floats | None,
    trials: Iterable[TrainingTrial],
    validation: Iterable[TrainingTrial] | None,
    schedule: Schedule,
    *,
    partial: Partial,
    seed: int,
    device: str,
    progress: bool,
) -> Fitted:
    """Learn a net of these sizes; `differences` treats the forces of a trial, unscaled. Raises ValueError.

    Trials are taken one by one and their frames let go.
    """
    from slip.net_training import learn, torch_device

    torch_device(device)
    learning = [_prepare(trial, sizes, differences, partial) for trial in trials]
    if validation is None:
        learning, held_back = _split(learning, seed)
    else:
        held_back = [_prepare(trial, sizes, differences, partial) for trial in validation]
    if not learning or not held_back:
        raise ValueError(f"expected trials to learn from and to validate on, got {len(learning)} and {len(held_back)}")
    shape = replace(sizes, taxels=learning[0].differences.shape[1])
    for trial in (*learning, *held_back):
        if trial.differences.shape[1] != shape.taxels:
            raise ValueError(f"expected {shape.taxels} taxels as in the first trial, got {trial.differences.shape[1]}")
    if scale is None:
        scale = noise_scale([trial.differences[trial.stick] for trial in learning])
    frame_scale = _frame_scale([trial.change for trial in learning if trial.change is not None])
    pieces, checks = (cut_pieces(each, shape.reach, scale, frame_scale) for each in (learning, held_back))
    weights, history, epoch = learn(shape, pieces, checks, schedule, seed=seed, device=device, progress=progress)
    return Fitted(Net(shape, weights, frame_scale), scale, history, epoch)


def noise_scale(sticking: Sequence[Floats]) -> Floats:
    """Rms noise (taxels,) of differences (T, taxels) while nothing slips, from the calm quarter of their blocks."""
    rms = [
        np.sqrt((each[first : first + NOISE_BLOCK] ** 2).mean(axis=0))
        for each in sticking
        for first in range(1, len(each) - NOISE_BLOCK + 1, NOISE_BLOCK)  # the first sample has no difference
    ]
    overall = measure_rest(np.concatenate(list(sticking))).scale
    calm = np.quantile(rms, NOISE_QUANTILE, axis=0) if rms else overall
    return np.where(calm > 0.0, calm, overall)


def _frame_scale(changes_: Sequence[Floats]) -> float:
    if not changes_:
        return 1.0
    rms = np.sqrt(np.concatenate([(each[1:] ** 2).mean(axis=(1, 2, 3)) for each in changes_]))
    moving = rms[rms > 0.0]
    return float(np.quantile(moving, NOISE_QUANTILE)) if len(moving) else 1.0


def _split(trials: Sequence[Prepared], seed: int) -> tuple[list[Prepared], list[Prepared]]:
    order = np.random.default_rng([seed, HELD_BACK]).permutation(len(trials))
    back = set(order[: max(len(trials) // HELD_BACK, 1)].tolist())
    return [t for i, t in enumerate(trials) if i not in back], [t for i, t in enumerate(trials) if i in back]


def _prepare(
    trial: TrainingTrial, sizes: NetShape, differences: Callable[[Floats], Floats], partial: Partial
) -> Prepared:
    target, weight = labels(trial.state, partial)
    change, at = None, np.zeros(0, dtype=np.int64)
    if sizes.embedding:
        if trial.frames is None or trial.frame_samples is None or len(trial.frames) == 0:
            raise ValueError("expected frames in every trial: this net looks at the camera too")
        change, at = changes(downsample(trial.frames, sizes.grid)), trial.frame_samples
    return Prepared(differences(trial.force), trial.state == STICK, target, weight, change, at)
