"""What the light on a gel's membrane depends on, as columns of a linear model.

Local: powers of the horizontal part of the unit normal (bounded however steep the surface; Lambert's law under distant
light is its first power, lobes and saturation need more). Cast shadows: the elevation of the horizon in evenly spaced
directions, and its square. Each column counts in proportion to powers of the place in the frame, since lights are near.

The polynomial of gradient and place is that of Z. Si, W. Yuan, "Taxim: an example-based simulation model for GelSight
tactile sensors", IEEE RA-L 7(2), 2022; the bounded normal and the horizons are ours.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from sensors.optics.horizon import horizon_elevation

Frame = tuple[slice, slice]
"""Rows and columns of a surface that the camera sees."""


class ShadingRecipe(BaseModel):
    """Orders of the model; lengths are in pixels of the surface that it is given."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    normal_degree: int = Field(6, ge=1, le=8, description="highest power of the normal's horizontal part")
    place_degree: int = Field(2, ge=0, le=3, description="highest power of the place in the frame")
    horizons: int = Field(12, ge=0, le=16, description="directions in which shadows are looked for")
    blur_px: float = Field(1.0, ge=0, description="Gaussian blur of the surface: optics and membrane smooth its edges")
    reach_px: float = Field(110.0, gt=2, description="longest shadow")

    @property
    def n_surface(self) -> int:
        """Columns that depend on the surface."""
        return _triangle(self.normal_degree) - 1 + 2 * self.horizons

    @property
    def n_place(self) -> int:
        """Powers of the place, the constant among them."""
        return _triangle(self.place_degree)


def surface_terms(height_px: NDArray[np.floating], recipe: ShadingRecipe, frame: Frame) -> NDArray[np.float32]:
    """Columns of the model that depend on the surface, (n_surface, frame rows, frame columns); zero where it is flat.

    `height_px` (rows, columns; both even) is the displacement towards the camera in its own pixels. It is wider than
    the frame, so that what stands beside the frame casts its shadow into it.
    """
    height = np.asarray(height_px, np.float32)
    smooth = _blurred(height, recipe.blur_px)
    slope_y: NDArray[np.float32] = np.gradient(smooth, axis=0)[frame]
    slope_x: NDArray[np.float32] = np.gradient(smooth, axis=1)[frame]
    inverse_norm = 1 / np.sqrt(1 + slope_x**2 + slope_y**2)
    local = _powers(slope_x * inverse_norm, slope_y * inverse_norm, recipe.normal_degree)[1:]
    shadows = _horizons(height, recipe, frame)
    return np.stack([*local, *shadows, *(elevation**2 for elevation in shadows)])


def place_terms(shape: tuple[int, int], recipe: ShadingRecipe) -> NDArray[np.float32]:
    """Powers of the place, (n_place, rows, columns); x and y run from -1 to 1 over a frame of `shape`."""
    rows, columns = shape
    y = ((np.arange(rows, dtype=np.float32) + 0.5) / rows * 2 - 1)[:, None]
    x = ((np.arange(columns, dtype=np.float32) + 0.5) / columns * 2 - 1)[None, :]
    return np.stack(_powers(np.broadcast_to(x, shape), np.broadcast_to(y, shape), recipe.place_degree))


def _horizons(height: NDArray[np.float32], recipe: ShadingRecipe, frame: Frame) -> list[NDArray[np.float32]]:
    """Elevations in each direction, looked for on every other pixel: shadows have no finer detail."""
    rows, columns = height.shape
    coarse = cv2.resize(height, (columns // 2, rows // 2), interpolation=cv2.INTER_AREA) / 2
    found = []
    for number in range(recipe.horizons):
        elevation = horizon_elevation(coarse, 2 * np.pi * number / recipe.horizons, recipe.reach_px / 2)
        fine = cv2.resize(elevation, (columns, rows), interpolation=cv2.INTER_LINEAR)
        found.append(_blurred(fine, recipe.blur_px)[frame])
    return found


def _triangle(degree: int) -> int:
    return (degree + 1) * (degree + 2) // 2


def _powers(x: NDArray[np.float32], y: NDArray[np.float32], degree: int) -> list[NDArray[np.float32]]:
    """x^i y^j for i + j <= degree, the constant first."""
    of_x, of_y = [np.ones_like(x)], [np.ones_like(y)]
    for _ in range(degree):
        of_x.append(of_x[-1] * x)
        of_y.append(of_y[-1] * y)
    return [of_x[i] * of_y[total - i] for total in range(degree + 1) for i in range(total, -1, -1)]


def _blurred(field: NDArray[np.float32], sigma_px: float) -> NDArray[np.float32]:
    return cv2.GaussianBlur(field, (0, 0), sigma_px, borderType=cv2.BORDER_REPLICATE) if sigma_px > 0 else field
