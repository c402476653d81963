"""Titles and order of the ids that the board knows; an id that it does not know is shown as it is, after the others."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

CLASSIFIERS = {
    "ksc": "KSC",
    "jksc": "JKSC",
    "jksc-independent": "JKSC, independent",
    "knn": "kNN",
    "wknn": "weighted kNN",
    "ipca-wknn": "incremental PCA + weighted kNN",
    "svm": "SVM",
    "late-fusion": "network, late fusion",
    "fusion-transformer": "network, transformer",
    "late-fusion-no-dropout": "network, late fusion, no modality dropout",
    "fusion-transformer-no-dropout": "network, transformer, no modality dropout",
}
DETECTORS = {
    "covariance": "covariance",
    "covariance-taxel": "covariance, taxel side",
    "covariance-mean-removed": "covariance, mean removed",
    "covariance-load-removed": "covariance, load removed",
    "covariance-load-ratio": "covariance, load ratio",
    "energy": "energy",
    "energy-load-removed": "energy, load removed",
    "spectral": "high-band energy",
    "neural-force": "network, force",
    "neural-force-frames": "network, force + frames",
}
METHODS = CLASSIFIERS | DETECTORS
MODALITIES = {
    "force": "force",
    "image": "image",
    "image-change": "image change",
    "fused": "force + image",
    "fused-equal": "force + image, equal",
    "fused-change": "force + image change",
    "fused-change-equal": "force + image change, equal",
    "pixels-change": "pixels of the change",
    "fused-pixels": "force in time + pixels",
    "fused-pixels-change": "force in time + pixels of the change",
    "fused-pixels-change-equal": "force in time + pixels of the change, equal",
    "force-series": "force in time",
    "force-series-image": "force in time + image",
    "spectrum": "spectrum",
    "coefficients": "Fourier coefficients",
    "prior": "force, β from an earlier slip",
    "cfar": "force, β for a rate of false alarms",
    "electrodes": "electrodes",
    "load-centroid": "load centroid only",
    "total-force": "total force only",
    "rest-frame": "frame without contact",
    "mean-levels": "mean levels only",
    "proximity": "proximity channels only",
    "palm-pose": "palm pose only",
    "shuffled-labels": "shuffled labels",
    "true-displacement": "true displacement field",
}
SPLITS = {
    "random": "random split",
    "held-out-unit": "held-out unit",
    "held-out-setting": "held-out grip setting",
    "held-out-session": "held-out session",
    "held-out-object": "held-out object",
    "held-out-sequence": "held-out sequence",
    "all": "every recording",
    "hidden": "hidden test set",
}
VARIANTS = ("paper", "default", "hard", "public", "own", "no-variation")
ROLES = ("method", "upper-line", "probe", "law")

USUAL_BACKBONE = "efficientnet-lite0"
"""Features of frames come from it where nothing else is said."""
BY = "@"
"""Between a feed and the backbone of its frames."""

Key = tuple[int, tuple[int | float, str], str]


def title(kind: dict[str, str], name: str) -> str:
    """Return the title of an id in METHODS, MODALITIES or SPLITS, or the id itself; a feed's backbone in brackets."""
    plain, _, backbone = name.partition(BY)
    return f"{kind.get(plain, plain)} ({backbone})" if backbone else kind.get(name, name)


def fed_with(modality: str, params: Mapping[str, Any]) -> str:
    """Return a feed's id with the backbone of its frames where that is not the usual one: `image@vt-vgg`."""
    backbone = params.get("backbone", USUAL_BACKBONE)
    return modality if backbone == USUAL_BACKBONE else f"{modality}{BY}{backbone}"


def order(known: dict[str, str] | tuple[str, ...], name: str) -> Key:
    """Return a sort key: known ids in their order, then the rest by the number in them, then by name."""
    names = tuple(known)
    plain = name.partition(BY)[0]
    place = names.index(plain) if plain in names else len(names)
    return place, natural(name), name


def natural(name: str) -> tuple[int | float, str]:
    """Return the first number in a name with what stands before it, so that 2 mm comes before 10 mm."""
    found = re.search(r"\d+(\.\d+)?", name)
    return (float(found.group()), name[: found.start()]) if found else (-1, name)
