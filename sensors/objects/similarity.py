"""Which objects are hardest to tell apart: distances between what the skin meets of them."""

from functools import lru_cache
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from sensors.objects.household import names
from sensors.objects.raster import heightfield, place

Array = NDArray[np.float32]

REGION_M = 0.08
REACH_M = 0.005
"""The skin meets at most this much of an object below its top."""

_GRID = 64
_MARGIN = 5
_TURNS = 72


def nearest_pairs(count: int = 10) -> list[tuple[str, str, float]]:
    """The `count` most alike pairs of objects, nearest first, as (name, name, rms difference in millimetres).

    Compared are the upper 5 mm of each object over the 80 x 80 mm under the skin (64 x 64 cells), at the best
    of 72 turns and of all shifts up to 6 mm. A count below one raises a ValueError.
    """
    if count < 1:
        raise ValueError(f"nearest_pairs wants at least one pair, got {count}")
    return list(_ranking(names())[:count])


def met(name: str, grid_n: int, size_m: float, angle_rad: float) -> Array:
    """The part (grid_n, grid_n) of an object that the skin can meet, in mm above `REACH_M` below its top."""
    floor = float(heightfield(name).max()) - REACH_M
    height = place(name, grid_n, size_m, 0.0, 0.0, angle_rad)
    return np.asarray(1e3 * np.maximum(height - floor, 0.0), np.float32)


@lru_cache(maxsize=1)
def _ranking(every: tuple[str, ...]) -> list[tuple[str, str, float]]:
    """All pairs, nearest first."""
    still = {name: met(name, _GRID, REGION_M, 0.0) for name in every}
    turned = {name: _turns(name) for name in every}
    pairs = [(a, b, _distance(still[a], turned[b])) for a, b in combinations(every, 2)]
    return sorted(pairs, key=lambda pair: pair[2])


def _turns(name: str) -> list[Array]:
    wide = _GRID + 2 * _MARGIN
    size = REGION_M * wide / _GRID
    return [met(name, wide, size, 2.0 * np.pi * turn / _TURNS) for turn in range(_TURNS)]


def _distance(fixed: Array, turned: list[Array]) -> float:
    """Root of the smallest mean squared difference over all turns and shifts."""
    best = min(float(cv2.matchTemplate(wide, fixed, cv2.TM_SQDIFF).min()) for wide in turned)
    return float(np.sqrt(max(best, 0.0) / fixed.size))
