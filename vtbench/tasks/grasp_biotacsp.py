"""Will the grasp hold? Real readings of three BioTac SP fingertips before the object is lifted.

Data: BioTac SP Stability Set v2, 5,831 grasps, 72 electrodes read once, in three poses of the palm; raw counts.
Target: stable or slipped. Splits: the published one, 41 objects to learn from and 10 unseen ones, tested once; and
random draws over all grasps, in which an object's other grasps are known.
Metrics: accuracy, balanced accuracy. Intervals: over the ten unseen objects; over grasps for random draws.
Choices: on folds of training objects. Probes: the pose of the palm alone, the mean level of each finger, shuffled
labels. Seen elsewhere on the published split: weighted nearest neighbours 0.688, RBF SVM 0.707.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from vtbench.tasks.base import (
    Block,
    FeatureCache,
    Features,
    Feed,
    Fold,
    NotPossibleError,
    Split,
    Task,
    TaskData,
    Variant,
)
from vtbench.tasks.splits import guarded, random_draws

CLASSES = ("stable", "slipped")


def load(path: Path, cache: FeatureCache, backbone: str) -> TaskData:
    """All grasps below `path`; `backbone` is for tasks with frames."""
    from vtbench.data.biotacsp_stability_v2 import FINGERS, PALMS, load_biotacsp_stability_v2

    grasps = load_biotacsp_stability_v2(path)
    sources: dict[str, Callable[[], Features]] = {
        "electrodes": lambda: grasps.electrodes.astype(np.float32),
        "mean-levels": lambda: grasps.electrodes.reshape(len(grasps), len(FINGERS), -1).mean(2).astype(np.float32),
        "palm-pose": lambda: np.stack([grasps.palm == palm for palm in PALMS], 1).astype(np.float32),
    }
    return TaskData(
        ids=grasps.id,
        labels=grasps.slipped.astype(np.int64),
        classes=CLASSES,
        factors={"object": grasps.object, "palm": grasps.palm, "unseen": grasps.unseen},
        rows=np.arange(len(grasps)),
        sources=sources,
    )


def published(data: TaskData, seed: int) -> Split:
    """Learn from the 41 training objects, test once on the 10 others; inner folds hold out training objects.

    Raises:
        NotPossibleError: no unseen object among these grasps.
    """
    objects, unseen = data.factor("object"), data.factor("unseen")
    if not unseen.any():
        raise NotPossibleError("these grasps hold no unseen object")
    fold = Fold("unseen-objects", np.flatnonzero(~unseen), np.flatnonzero(unseen))
    split = Split("held-out-object", (fold,), objects.astype(np.str_), "object", inner_groups=objects)
    return guarded(split, data, held_out=objects)


_ELECTRODES = Block("electrodes")

TASK = Task(
    id="grasp/biotacsp/v1",
    about="foretell whether a grasp holds, from one reading before the lift",
    reads="biotacsp_stability_v2",
    load=load,
    variants={
        "public": Variant(
            "every grasp of the public set",
            {
                "random": random_draws(test_fraction=1 / 10, runs=2, strata=("palm",), group_kind="grasp"),
                "held-out-object": published,
            },
        )
    },
    modalities={"electrodes": Feed((_ELECTRODES,))},
    probes={
        "palm-pose": Feed((Block("palm-pose"),)),
        "mean-levels": Feed((Block("mean-levels"),)),
        "shuffled-labels": Feed((_ELECTRODES,), shuffle_labels=True),
    },
)
