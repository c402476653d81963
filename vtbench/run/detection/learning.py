"""Detectors that learn: fitted on training trials with the state of the contact, never on a test trial."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import slip
from vtbench.run.detection.looking import WITH_FRAMES, frames_of
from vtbench.tasks.base import NotPossibleError
from vtbench.tasks.slides import SlideData

if TYPE_CHECKING:
    from slip import TrainingTrial

LEARNT = slip.learnt_detector_names()
MOST_TRIALS = 120
EPOCHS = 12


def learnt(name: str, data: SlideData, train: NDArray[np.int64]) -> Any:
    """A detector fitted on up to `MOST_TRIALS` training trials, evenly over their order; one seed for all.

    Raises:
        NotPossibleError: the training trials do not tell when they slip.
    """
    chosen = [trial for trial in train.tolist() if data.truth[trial].comparable]
    chosen = [chosen[at] for at in np.unique(np.linspace(0, len(chosen) - 1, MOST_TRIALS).round().astype(int))]
    try:
        return slip.make_detector(name).fit(_trials(data, chosen, name in WITH_FRAMES), epochs=EPOCHS, seed=0)
    except ValueError as error:
        raise NotPossibleError(f"nothing to learn slip from: {error}") from None


def _trials(data: SlideData, chosen: list[int], with_frames: bool) -> Iterator[TrainingTrial]:
    states = data.states(chosen)
    for trial, force in data.each_force(chosen):
        yield slip.TrainingTrial(force, states[trial], **(frames_of(data, trial) if with_frames else {}))
