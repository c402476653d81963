"""How high the surface stands above a point when it looks along the window: what casts shadows under grazing light."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

_GROWTH = 1.25
"""Steps along a ray grow by this: what is narrower than a quarter of its distance may be missed, as are its shadow's
last pixels; soft gels and extended lights leave nothing so fine."""


def horizon_elevation(height: NDArray[np.floating], azimuth_rad: float, reach_px: float) -> NDArray[np.float32]:
    """Elevation (rad, >= 0) of the horizon in one direction, for every point of a surface.

    Args:
        height: (rows, columns) in pixels, towards the lights.
        azimuth_rad: direction of the look, from +x (columns) to +y (rows).
        reach_px: how far the ray is followed; the surface goes on as at its border.

    Returns:
        (rows, columns) float32: max over s of atan((height(p + s d) - height(p)) / s), never below 0.
    """
    surface = np.asarray(height, np.float32)
    rows, columns = surface.shape
    steepest = np.zeros_like(surface)
    how = {"flags": cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, "borderMode": cv2.BORDER_REPLICATE}
    distance = 1.0
    while distance <= reach_px:
        x, y = distance * math.cos(azimuth_rad), distance * math.sin(azimuth_rad)
        ahead = cv2.warpAffine(surface, np.array([[1, 0, x], [0, 1, y]]), (columns, rows), **how)
        np.maximum(steepest, (ahead - surface) / np.float32(distance), out=steepest)
        distance *= _GROWTH
    return np.arctan(steepest)
