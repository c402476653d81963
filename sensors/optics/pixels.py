"""What a camera does at each pixel: light on a facet, then a grey level with the sensor's noise.

Single precision and one pass each, row by row; every value comes from its own pixel alone, so bytes do not depend on
how many pixels a machine works on at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sensors.compiled import compiled

Single = NDArray[np.float32]


@compiled
def shade(facet: Single, slope_x: Single, slope_y: Single, gain: Single) -> Single:
    """Grey levels (3, rows, columns), >= 0, of facets with normal (-slope_x, -slope_y, 1), made unit.

    `facet` (3 channels, 3 components, rows, columns) is the light that falls on each pixel, times its reflectance;
    `slope_x`, `slope_y` (rows, columns); `gain` (3,).
    """
    rows, columns = slope_x.shape
    one, dark = np.float32(1), np.float32(0)
    levels = np.empty((3, rows, columns), np.float32)
    inverse_norm = np.empty(columns, np.float32)
    for row in range(rows):
        for x in range(columns):
            along, down = slope_x[row, x], slope_y[row, x]
            # a division by `/` is checked for zero, which keeps the loop from running on several pixels at once
            inverse_norm[x] = np.reciprocal(np.sqrt(one + along * along + down * down))
        for channel in range(3):
            for x in range(columns):
                falling = facet[channel, 2, row, x]
                falling -= facet[channel, 0, row, x] * slope_x[row, x]
                falling -= facet[channel, 1, row, x] * slope_y[row, x]
                falling *= inverse_norm[x]
                levels[channel, row, x] = (falling if falling > dark else dark) * gain[channel]
    return levels


@compiled
def expose(
    levels: Single, words: NDArray[np.uint64], normal: Single, read_variance: float, shot_variance: float
) -> NDArray[np.uint8]:
    """A frame (rows, columns, 3) uint8 of noise-free `levels` (3, rows, columns), rounded and cut to 0..255.

    Noise of variance `read_variance + shot_variance * level`: each 16 bits of the random `words` (at least a quarter as
    many as values) pick from `normal`, the table of `sensors.optics.noise.normal_table`.
    """
    _, rows, columns = levels.shape
    width = 3 * columns
    black, white = np.float32(0), np.float32(255)
    read, shot = np.float32(read_variance), np.float32(shot_variance)
    noise, grey = np.empty(width, np.float32), np.empty(width, np.uint8)
    frame = np.empty((rows, columns, 3), np.uint8)
    for row in range(rows):
        for at in range(width):
            number = row * width + at
            noise[at] = normal[(words[number >> 2] >> np.uint64(16 * (number & 3))) & np.uint64(0xFFFF)]
        for channel in range(3):
            for x in range(columns):
                level = levels[channel, row, x]
                seen = np.rint(level + noise[channel * columns + x] * np.sqrt(read + shot * level))
                seen = seen if seen > black else black
                grey[channel * columns + x] = np.uint8(seen if seen < white else white)
        for x in range(columns):
            for channel in range(3):
                frame[row, x, channel] = grey[channel * columns + x]
    return frame
