"""Which of many distances are the smallest: one compiled pass, where a full sort would order what nobody asks for."""

from __future__ import annotations

import numpy as np

from fusion.arrays import FloatArray, IntArray
from fusion.compiled import compiled


def smallest(distances: FloatArray, count: int) -> IntArray:
    """Places of the `count` smallest of each row of distances (q, n), ascending, the earlier first of equals.

    (q, min(count, n)), as the first columns of a stable argsort; distances hold no NaN.
    """
    places = np.empty((len(distances), min(count, distances.shape[1])), np.intp)
    _smallest(distances, places)
    return places


@compiled
def _smallest(distances: FloatArray, places: IntArray) -> None:
    count = places.shape[1]
    for row in range(len(distances)):
        for place in range(distances.shape[1]):
            value = distances[row, place]
            if place >= count and not value < distances[row, places[row, count - 1]]:
                continue
            at = min(place, count - 1)
            while at > 0 and value < distances[row, places[row, at - 1]]:
                places[row, at] = places[row, at - 1]
                at -= 1
            places[row, at] = place
