"""Force differences between adjacent samples, and three ways to take a coherent load change out of them.

The FVSight paper's detector works on d_i(t) = f_i(t) - f_i(t-1) (its equation 12). A load change without slip
moves all taxels together, and so correlates the differences in time just as slip does. Each function below is
applied sample by sample, so that a stream and a batch give the same bits.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from slip.samples import Floats

CommonMode = Literal["keep", "mean", "load", "ratio"]
COMMON_MODES: tuple[CommonMode, ...] = ("keep", "mean", "load", "ratio")
RATIO_FLOOR_N = 0.2  # the stated resolution of the FVSight array


def remove_mean(difference: Floats) -> Floats:
    """Subtract each sample's mean over the taxels; (T, taxels) -> (T, taxels) in newtons.

    What all taxels feel alike, such as a shared supply or a plane push, vanishes.
    """
    return difference - difference.sum(axis=1, keepdims=True) / difference.shape[1]


def remove_load(difference: Floats, previous: Floats) -> Floats:
    """Subtract each difference's part along the load pattern before it; both (T, taxels) in newtons.

    A load that rises or falls with a fixed pattern over the taxels, f(t) = a(t) p, leaves nothing to
    rounding. Where the array carries no load there is no pattern and the difference is kept.
    """
    energy = (previous * previous).sum(axis=1, keepdims=True)
    along = (previous * difference).sum(axis=1, keepdims=True)
    share = np.divide(along, energy, out=np.zeros_like(along), where=energy > 0.0)
    return difference - share * previous


def relate_to_load_change(difference: Floats, floor_n: float = RATIO_FLOOR_N) -> Floats:
    """Divide each difference by the change of the total force beside it plus a floor; dimensionless.

    Whatever its size, a load change whose taxels move the same way gives magnitudes that sum to less than 1;
    a redistribution of load at constant total, as in slip, is divided by the floor alone.
    """
    change = np.abs(difference.sum(axis=1, keepdims=True))
    return difference / (change + floor_n)


def treat(difference: Floats, previous: Floats, common_mode: CommonMode) -> Floats:
    """Apply the named treatment of the common mode to differences (T, taxels) that follow `previous`."""
    if common_mode == "mean":
        return remove_mean(difference)
    if common_mode == "load":
        return remove_load(difference, previous)
    if common_mode == "ratio":
        return relate_to_load_change(difference)
    return difference
