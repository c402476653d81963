"""Upper envelope of a triangle mesh on a grid: a vectorised z-buffer."""

from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sensors.objects.mesh import Mesh

Array = NDArray[np.float64]

_PIXELS_PER_CHUNK = 2_000_000
_RASTER_PITCH_MM = 0.1


def rasterise(mesh: Mesh, x: Array, y: Array) -> Array:
    """Height (len(y), len(x)) of the upper envelope at points of a uniform grid; 0 where nothing is hit.

    Exact for the facets: each grid point takes the plane of the highest triangle above it. Triangles are
    worked on in groups of like size in pixels, so that small ones do not pay for large ones. What lies below
    the table reads as zero.
    """
    corners = mesh.vertices[mesh.faces].copy()
    corners[..., 0] = (corners[..., 0] - x[0]) / (x[1] - x[0])
    corners[..., 1] = (corners[..., 1] - y[0]) / (y[1] - y[0])
    first = np.ceil(corners[..., :2].min(1) - 1e-9).astype(int)
    last = np.floor(corners[..., :2].max(1) + 1e-9).astype(int)
    side = (last - first + 1).max(1)
    met = (last >= first).all(1) & (last >= 0).all(1) & (first < (len(x), len(y))).all(1)
    height = np.zeros(len(x) * len(y))
    for group, reach in _groups(np.where(met, side, 0)):
        index, z = _cover(corners[group], first[group], reach, len(x), len(y))
        np.maximum.at(height, index, z)
    return height.reshape(len(y), len(x))


def _groups(side: NDArray[np.int_]) -> Iterator[tuple[NDArray[np.intp], int]]:
    """Triangle numbers in chunks of like bounding-box side, with a side that covers the chunk."""
    reach = 1
    while (side >= reach).any():
        members = np.flatnonzero((side >= reach) & (side < 2 * reach))
        span = 2 * reach - 1
        step = max(1, _PIXELS_PER_CHUNK // span**2)
        for start in range(0, len(members), step):
            yield members[start : start + step], span
        reach *= 2


def _cover(
    corners: Array, first: NDArray[np.int_], reach: int, columns: int, rows: int
) -> tuple[NDArray[np.intp], Array]:
    """Flat grid numbers under each triangle and the heights of its plane there."""
    column = first[:, 0, None, None] + np.arange(reach)[None, None, :]
    row = first[:, 1, None, None] + np.arange(reach)[None, :, None]
    a, b, c = (corners[:, k, :, None, None] for k in range(3))
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    flat = np.abs(area) < 1e-12
    scale = 1.0 / np.where(flat, 1.0, area)
    wa = ((b[:, 0] - column) * (c[:, 1] - row) - (c[:, 0] - column) * (b[:, 1] - row)) * scale
    wb = ((c[:, 0] - column) * (a[:, 1] - row) - (a[:, 0] - column) * (c[:, 1] - row)) * scale
    wc = 1.0 - wa - wb
    inside = ~flat & (np.minimum(np.minimum(wa, wb), wc) >= -1e-9)
    inside &= (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    z = wa * a[:, 2] + wb * b[:, 2] + wc * c[:, 2]
    return (row * columns + column)[inside], z[inside]


class MeshSurface:
    """Height function of a mesh inside a box: rasterised once at 0.1 mm, read by bilinear interpolation."""

    def __init__(self, build: Callable[[], Mesh], size_mm: tuple[float, float], centre_mm: tuple[float, float]) -> None:
        self.build = build
        self.size_mm = size_mm
        self.centre_mm = centre_mm

    def __call__(self, x: Array, y: Array) -> Array:
        """Height in millimetres at points in millimetres; 0 outside the box."""
        return _interpolate(_raster(self), self._start, x, y)

    @property
    def _start(self) -> Array:
        cells = np.ceil(np.asarray(self.size_mm) / _RASTER_PITCH_MM / 2.0) + 1
        return np.asarray(self.centre_mm) - cells * _RASTER_PITCH_MM

    def _axes(self) -> tuple[Array, Array]:
        start = self._start
        counts = np.rint(2.0 * (np.asarray(self.centre_mm) - start) / _RASTER_PITCH_MM).astype(int) + 1
        return (
            start[0] + _RASTER_PITCH_MM * np.arange(counts[0]),
            start[1] + _RASTER_PITCH_MM * np.arange(counts[1]),
        )


@lru_cache(maxsize=64)
def _raster(surface: MeshSurface) -> Array:
    return rasterise(surface.build(), *surface._axes())


def _interpolate(raster: Array, start: Array, x: Array, y: Array) -> Array:
    rows, columns = raster.shape
    u, v = (x - start[0]) / _RASTER_PITCH_MM, (y - start[1]) / _RASTER_PITCH_MM
    inside = (u >= 0) & (u <= columns - 1) & (v >= 0) & (v <= rows - 1)
    u, v = np.where(inside, u, 0.0), np.where(inside, v, 0.0)
    i, j = np.minimum(v.astype(int), rows - 2), np.minimum(u.astype(int), columns - 2)
    s, t = v - i, u - j
    upper = (1.0 - t) * raster[i, j] + t * raster[i, j + 1]
    lower = (1.0 - t) * raster[i + 1, j] + t * raster[i + 1, j + 1]
    return np.asarray(np.where(inside, (1.0 - s) * upper + s * lower, 0.0))
