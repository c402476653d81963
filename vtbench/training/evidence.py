"""Evidence on validation shapes: how well features tell unseen shapes apart on a sensor unit that was held out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vtbench.training.presses import Arrays

COMPONENTS = 32
NEIGHBOURS = 3


@dataclass(frozen=True)
class Evidence:
    """Accuracy, 0 to 1, on held-out units by what is fed and how a shape lies."""

    change_same_pose: float
    frame_same_pose: float
    change_any_pose: float
    frame_any_pose: float

    @property
    def mean(self) -> float:
        """What the checkpoint is chosen by."""
        return (self.change_same_pose + self.frame_same_pose + self.change_any_pose + self.frame_any_pose) / 4


def evidence(change: NDArray[np.float32], frame: NDArray[np.float32], presses: Arrays) -> Evidence:
    """Evidence of features (n, columns) of the changes and of the frames of validation presses."""
    anywhere = presses["any_pose"].astype(bool)
    values = [
        held_out_accuracy(features[rows], presses["shape"][rows], presses["unit"][rows])
        for rows in (~anywhere, anywhere)
        for features in (change, frame)
    ]
    return Evidence(*values)


def held_out_accuracy(features: NDArray[np.float32], labels: NDArray[np.generic], units: NDArray[np.generic]) -> float:
    """Mean accuracy over units, each held out in turn: standardised, PCA, k nearest neighbours of the other units."""
    from sklearn.decomposition import PCA
    from sklearn.neighbors import KNeighborsClassifier
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    scores = []
    for unit in np.unique(units):
        test = units == unit
        components = min(COMPONENTS, int((~test).sum()), features.shape[1])
        model = make_pipeline(
            StandardScaler(), PCA(components, random_state=0), KNeighborsClassifier(NEIGHBOURS, weights="distance")
        )
        model.fit(features[~test], labels[~test])
        scores.append(float(np.mean(model.predict(features[test]) == labels[test])))
    return float(np.mean(scores))
