"""What a small change of load, or a shear force, at a point of the contact does to the taxels below.

The film spreads a point load over a distance of its thickness before the taxels feel it. Along one axis the share that
a tile of taxel i collects from a cell at x is B_i(x): the tile, blurred by the film's base transfer and by the cell's
width. The share of taxel (i, j) is taken as B_i(y) B_j(x), exact but for the rounding of tile corners.

A shear force does not press, but it tips the film: through a film of thickness h under traction t the balance of a
slice gives the base pressure p - h dt/dx, so a cell that drags with force F moves h (F . grad) of the share between the
taxels, towards the side to which it drags.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sensors.contact.layer import LayerMaterial
from sensors.fvsight import TAXELS_PER_SIDE

Array = NDArray[np.float64]
_STEP_M = 5e-5
_CHUNK = 2000
"""Samples worked on at a time, to bound the memory of a long trial."""


@dataclass(frozen=True)
class Footprint:
    """Shares B (points, 4) of the tiles along one axis and their slope (1/m), tabulated from `low_m` in `_STEP_M`."""

    low_m: float
    share: Array
    slope: Array
    film_thickness_m: float

    @classmethod
    def of(cls, film: LayerMaterial, region_m: float, cell_m: float) -> Footprint:
        """Tabulate the shares for a film, a region and friction cells of edge `cell_m`."""
        points = 2 ** int(np.ceil(np.log2(2 * region_m / _STEP_M)))
        position = (np.arange(points) - points / 2) * _STEP_M
        k: Array = 2 * np.pi * np.fft.rfftfreq(points, _STEP_M).astype(np.float64)
        blur = film.base_transfer(k) * np.sinc(k * cell_m / (2 * np.pi))
        tile = region_m / TAXELS_PER_SIDE
        # the outermost tiles take what falls beside the array, so that the shares always add up to one
        edges = [-np.inf, *(np.arange(1, TAXELS_PER_SIDE) * tile - region_m / 2), np.inf]
        inside = np.abs(position) < 0.75 * region_m
        share = np.stack(
            [
                np.fft.irfft(np.fft.rfft(((position >= low) & (position < high)).astype(float)) * blur, points)
                for low, high in pairwise(edges)
            ],
            axis=1,
        )[inside]
        return cls(float(position[inside][0]), share, np.gradient(share, _STEP_M, axis=0), film.thickness_m)

    def taxel_change(self, place: Array, load: Array, shear: Array) -> Array:
        """Change of the taxel loads (t, 16) for cells at `place` (t, n, 2).

        `load` (t, n; N) is what a cell carries beyond the smooth contact, `shear` (t, n, 2; N) its drag on the skin.
        """
        if len(place) > _CHUNK:
            parts = [slice(first, first + _CHUNK) for first in range(0, len(place), _CHUNK)]
            return np.concatenate([self.taxel_change(place[part], load[part], shear[part]) for part in parts])
        index, part = self._locate(place)
        across, slope_x = self._read(index[..., 0], part[..., 0])
        down, slope_y = self._read(index[..., 1], part[..., 1])
        moment = self.film_thickness_m * shear
        by_x = np.swapaxes(down * load[..., None] + slope_y * moment[..., 1:], 1, 2) @ across
        tipped = np.swapaxes(down * moment[..., :1], 1, 2) @ slope_x
        return np.asarray((by_x + tipped).reshape(len(place), TAXELS_PER_SIDE**2))

    def _locate(self, place: Array) -> tuple[NDArray[np.intp], Array]:
        at = np.clip((place - self.low_m) / _STEP_M, 0, len(self.share) - 1.001)
        index = at.astype(np.intp)
        return index, at - index

    def _read(self, index: NDArray[np.intp], part: Array) -> tuple[Array, Array]:
        weight = part[..., None]
        values = self.share[index] * (1 - weight) + self.share[index + 1] * weight
        slopes = self.slope[index] * (1 - weight) + self.slope[index + 1] * weight
        return values, slopes
