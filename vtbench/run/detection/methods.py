"""Slip detectors by id, as suites and tables name them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import slip
from vtbench.registry import Registry
from vtbench.run.detection.learning import EPOCHS, LEARNT, MOST_TRIALS

BASELINE = "energy"
"""Stands beside every other detector, asked for or not."""
_ABOUT = {
    "covariance": "largest row sum of the covariance of differences in time, the FVSight paper's",
    "covariance-taxel": "the same between taxels",
    "covariance-mean-removed": "covariance without the mean of the taxels",
    "covariance-load-removed": "covariance without what is in proportion to the load",
    "covariance-load-ratio": "covariance of each taxel's share of the load",
    "energy": "mean absolute difference, the baseline",
    "energy-load-removed": "mean absolute difference without what is in proportion to the load",
    "spectral": "energy of the differences above 150 Hz",
    "neural-force": "causal convolutional net over force differences, learnt on the training trials",
    "neural-force-frames": "the same net that also looks at the camera; needs trials with frames",
}


@dataclass(frozen=True)
class DetectorMethod:
    """A detector of `slip` in the grid; `source` is what else decides its scores, part of a record's key."""

    id: str
    about: str
    source: dict[str, Any] = field(default_factory=dict)
    joint: bool = False

    def identity(self) -> dict[str, Any]:
        """JSON values that decide the detector's scores."""
        return {"detector": self.id, **self.source}


DETECTORS: Registry[DetectorMethod] = Registry("detector", see="vtbench list detectors")

for _name in slip.detector_names():
    DETECTORS.register(_name)(DetectorMethod(_name, _ABOUT.get(_name, _name)))
for _name in LEARNT:
    _how = {"trials": MOST_TRIALS, "epochs": EPOCHS}
    DETECTORS.register(_name)(DetectorMethod(_name, _ABOUT.get(_name, _name), _how))


def plain_detectors() -> tuple[str, ...]:
    """Detectors that have nothing to learn but a threshold."""
    return slip.detector_names()


def with_baseline(ids: tuple[str, ...]) -> tuple[str, ...]:
    """The ids with the energy baseline among them."""
    return ids if BASELINE in ids else (*ids, BASELINE)
