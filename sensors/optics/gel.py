"""A gel camera calibrated on real presses: the rest frame times what the surface makes of its light.

rendered = rest * (1 + terms . weights), for each pixel and channel: albedo, vignette and lights stay in the rest frame,
the weights say how the light of the three LED groups changes with normal, shadow and place.
"""

from __future__ import annotations

import json
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from sensors.optics.gel_terms import Frame, ShadingRecipe, place_terms, surface_terms

CHANNELS = 3


class GelCalibration(BaseModel):
    """Weights of one sensor, plain numbers only; a small JSON file.

    `weights` [surface term][place term][channel]; `rest` [channel][power of y][power of x], Chebyshev coefficients of
    the rest frame in grey levels, for a unit whose own rest frame is not at hand; `made` says from what and how.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    sensor: str
    schema_version: int = Field(1, ge=1, le=1)
    frame_rows: int = Field(gt=0, multiple_of=2)
    frame_columns: int = Field(gt=0, multiple_of=2)
    pixel_mm: float = Field(gt=0)
    gel_thickness_mm: float = Field(gt=0, description="of the surfaces that the weights were fitted on")
    gel_poisson: float = Field(ge=0, le=0.5)
    recipe: ShadingRecipe
    ridge: float = Field(ge=0)
    weights: list[list[list[float]]]
    rest: list[list[list[float]]]
    noise_levels: float = Field(ge=0, description="standard deviation of a pixel between frames, grey levels")
    made: dict[str, Any]

    @model_validator(mode="after")
    def _shapes(self) -> GelCalibration:
        wanted = (self.recipe.n_surface, self.recipe.n_place, CHANNELS)
        got = np.shape(self.weights)
        if got != wanted:
            raise ValueError(f"weights must have the recipe's shape {wanted}, got {got}")
        if not np.isfinite(self.weights).all() or not np.isfinite(self.rest).all():
            raise ValueError("weights and rest must be finite")
        return self

    def rest_frame(self) -> NDArray[np.uint8]:
        """The smooth rest frame (rows, columns, 3) uint8 RGB: lights and vignette without the real membrane's marks."""
        grids = chebyshev_grids(self.frame_rows, self.frame_columns, len(self.rest[0]) - 1)
        levels = np.einsum("ri,kj,cij->rkc", *grids, np.asarray(self.rest))
        return np.clip(np.rint(levels), 0, 255).astype(np.uint8)

    def save(self, path: Path) -> None:
        """Write as JSON, a line for each surface term."""
        data = self.model_dump(mode="json")
        lines = [f"  {json.dumps(key)}: {_laid_out(value)}" for key, value in data.items()]
        path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")

    @classmethod
    def load(cls, path: Path) -> GelCalibration:
        """Read a calibration; ValueError of one line that names the file when it is none."""
        try:
            return cls.model_validate_json(path.read_bytes())
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(map(str, first["loc"])) or "the file"
            raise ValueError(f"{path}: not a gel calibration: {where}: {first['msg']}") from error


class GelShader:
    """A calibration ready to render; works on every other pixel, since light on a gel has no finer detail."""

    def __init__(self, calibration: GelCalibration) -> None:
        self.calibration = calibration
        self.shape = (calibration.frame_rows // 2, calibration.frame_columns // 2)

    @cached_property
    def _weight_maps(self) -> NDArray[np.float32]:
        """(surface terms, channels, rows, columns): the weights at each place."""
        places = place_terms(self.shape, self.calibration.recipe)
        weights = np.asarray(self.calibration.weights, np.float32)
        return np.einsum("spc,pyx->scyx", weights, places)

    def frame_of(self, surface_shape: tuple[int, ...]) -> Frame:
        """Where the camera's view lies in a surface that is centred on it and at least as wide."""
        starts = [(whole - seen) // 2 for whole, seen in zip(surface_shape, self.shape, strict=True)]
        if min(starts) < 0:
            raise ValueError(f"the surface must cover the frame's {self.shape} half pixels, got {surface_shape}")
        rows, columns = (slice(start, start + seen) for start, seen in zip(starts, self.shape, strict=True))
        return rows, columns

    def relative_change(self, height_px: NDArray[np.floating]) -> NDArray[np.float32]:
        """Relative change of the light, (frame rows, frame columns, 3), for a surface on every other pixel.

        `height_px` is in units of its own spacing (two camera pixels), centred on the frame and at least as wide.
        """
        terms = surface_terms(height_px, self.calibration.recipe, self.frame_of(height_px.shape))
        change = np.einsum("syx,scyx->yxc", terms, self._weight_maps, optimize=False)
        size = (self.calibration.frame_columns, self.calibration.frame_rows)
        return cv2.resize(change, size, interpolation=cv2.INTER_LINEAR)

    def render(
        self,
        height_px: NDArray[np.floating] | None,
        rest: NDArray[np.uint8],
        rng: np.random.Generator | None = None,
    ) -> NDArray[np.uint8]:
        """A frame (rows, columns, 3) uint8 RGB over the rest frame `rest`; without sensor noise where `rng` is None."""
        levels = rest.astype(np.float32)
        if height_px is not None:
            levels *= 1 + self.relative_change(height_px)
        if rng is not None:
            noise = rng.standard_normal(levels.shape, dtype=np.float32)
            levels += np.float32(self.calibration.noise_levels) * noise
        return np.clip(np.rint(levels), 0, 255).astype(np.uint8)


def chebyshev_grids(rows: int, columns: int, degree: int) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Chebyshev polynomials 0..degree at the pixel centres of both axes, (rows, degree + 1), (columns, degree + 1)."""
    y, x = ((np.arange(n) + 0.5) / n * 2 - 1 for n in (rows, columns))
    return np.polynomial.chebyshev.chebvander(y, degree), np.polynomial.chebyshev.chebvander(x, degree)


def _laid_out(value: Any) -> str:
    if isinstance(value, list) and value and isinstance(value[0], list):
        return "[\n" + ",\n".join(f"    {json.dumps(item)}" for item in value) + "\n  ]"
    return json.dumps(value)
