"""Objects on cell-centred grids: the cached fine heightfield, and an object placed under a sensor."""

import math
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from sensors.objects.household import get

Raster = NDArray[np.float32]

RASTER_N = 896
RASTER_SIZE_M = 0.14
"""Pitch 0.15625 mm: a whole number of raster cells in a cell of a 64, 128 or 256 grid over 80 mm."""


class _Patch(NamedTuple):
    """The part of a raster that holds the object, and the raster cell where it starts."""

    heights: Raster
    row: int
    column: int


class _Pose(NamedTuple):
    """Where the object's origin lies and how far it is turned, from x towards y."""

    x_m: float
    y_m: float
    cosine: float
    sine: float


def heightfield(name: str, n: int = RASTER_N, size_m: float = RASTER_SIZE_M) -> Raster:
    """Height (n, n) above the table in metres over a square of side `size_m` centred on the object's frame.

    Row is y, column is x, x_i = (i + 1/2) size/n - size/2; each cell is the mean of 2 x 2 samples. The
    default pitch of 0.156 mm keeps texture. Repeated calls are served from memory. An unknown name or a grid
    that is not positive raises a ValueError. For a coarse grid use `place`, which averages over whole cells.
    """
    patch = _patch(name, n, size_m)
    field = np.zeros((n, n), np.float32)
    rows, columns = patch.heights.shape
    field[patch.row : patch.row + rows, patch.column : patch.column + columns] = patch.heights
    return field


def place(name: str, grid_n: int, size_m: float, x_m: float, y_m: float, angle_rad: float) -> Raster:
    """Height (grid_n, grid_n) in metres under a sensor of side `size_m`, with the object moved and turned.

    The object's origin is at (x_m, y_m), turned from x towards y by `angle_rad`; each cell is the mean of the
    object over that cell, so that mean height does not depend on the grid. The table is 0, also beyond the
    raster. Errors as in `heightfield`; a pose that is not finite raises a ValueError too.
    """
    _check_grid(grid_n, size_m)
    if not np.isfinite([x_m, y_m, angle_rad]).all():
        raise ValueError(f"place {name!r}: x, y and angle must be finite, got {x_m}, {y_m}, {angle_rad}")
    patch = _patch(name, RASTER_N, RASTER_SIZE_M)
    pose = _Pose(x_m, y_m, math.cos(angle_rad), math.sin(angle_rad))
    placed = np.zeros((grid_n, grid_n), np.float32)
    rows, columns = _met(patch, pose, grid_n, size_m)
    if rows.stop > rows.start and columns.stop > columns.start:
        placed[rows, columns] = _cells(patch, pose, grid_n, size_m, rows, columns)
    return placed


def _met(patch: _Patch, pose: _Pose, grid_n: int, size_m: float) -> tuple[slice, slice]:
    """Rows and columns of the grid's cells that the turned patch may reach, with its blurred border."""
    pitch = RASTER_SIZE_M / RASTER_N
    height, width = patch.heights.shape
    along = (patch.column + 0.5 * width - 0.5 * RASTER_N) * pitch
    across = (patch.row + 0.5 * height - 0.5 * RASTER_N) * pitch
    cosine, sine = abs(pose.cosine), abs(pose.sine)
    half_x = 0.5 * pitch * (cosine * (width + 1) + sine * (height + 1))
    half_y = 0.5 * pitch * (sine * (width + 1) + cosine * (height + 1))
    x = pose.x_m + pose.cosine * along - pose.sine * across
    y = pose.y_m + pose.sine * along + pose.cosine * across

    def span(centre: float, half: float) -> slice:
        first = math.floor((centre - half) / size_m * grid_n + 0.5 * grid_n)
        last = math.floor((centre + half) / size_m * grid_n + 0.5 * grid_n)
        return slice(min(max(first, 0), grid_n), min(max(last + 1, 0), grid_n))

    return span(y, half_y), span(x, half_x)


def _cells(patch: _Patch, pose: _Pose, grid_n: int, size_m: float, rows: slice, columns: slice) -> Raster:
    """Means over these cells of the heights interpolated at about the raster's pitch."""
    pitch = RASTER_SIZE_M / RASTER_N
    samples = max(1, round(size_m / grid_n / pitch))
    step = size_m / grid_n / samples
    x = (columns.start * samples + 0.5) * step - 0.5 * size_m - pose.x_m
    y = (rows.start * samples + 0.5) * step - 0.5 * size_m - pose.y_m
    cosine, sine, zoom = pose.cosine, pose.sine, step / pitch
    origin = 0.5 * RASTER_N - 0.5
    matrix = np.array(
        [
            [cosine * zoom, sine * zoom, (cosine * x + sine * y) / pitch + origin - patch.column],
            [-sine * zoom, cosine * zoom, (cosine * y - sine * x) / pitch + origin - patch.row],
        ]
    )
    shape = (columns.stop - columns.start, rows.stop - rows.start)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    fine_shape = (shape[0] * samples, shape[1] * samples)
    fine: Raster = cv2.warpAffine(patch.heights, matrix, fine_shape, flags=flags, borderMode=cv2.BORDER_CONSTANT)
    return fine if samples == 1 else np.asarray(cv2.resize(fine, shape, interpolation=cv2.INTER_AREA))


@lru_cache(maxsize=128)
def _patch(name: str, n: int, size_m: float) -> _Patch:
    thing = get(name)
    _check_grid(n, size_m)
    pitch_mm = 1e3 * size_m / n
    spans = []
    for centre, size in zip(thing.centre_mm, thing.size_mm[:2], strict=True):
        low = int(np.floor((centre - 0.5 * size) / pitch_mm + 0.5 * n)) - 2
        high = int(np.ceil((centre + 0.5 * size) / pitch_mm + 0.5 * n)) + 2
        spans.append((min(max(low, 0), n - 1), max(min(high, n), 1)))
    (left, right), (top, bottom) = spans
    x = ((np.arange(2 * left, 2 * right) + 0.5) / (2 * n) - 0.5) * size_m
    y = ((np.arange(2 * top, 2 * bottom) + 0.5) / (2 * n) - 0.5) * size_m
    fine = thing.height(x[None, :], y[:, None])
    heights = fine.reshape(bottom - top, 2, right - left, 2).mean(axis=(1, 3)).astype(np.float32)
    heights.setflags(write=False)
    return _Patch(heights, top, left)


def _check_grid(n: int, size_m: float) -> None:
    if n < 1 or not np.isfinite(size_m) or size_m <= 0.0:
        raise ValueError(f"a grid needs at least one cell and a positive side in metres, got {n} cells over {size_m} m")
