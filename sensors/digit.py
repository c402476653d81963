"""DIGIT: a small gel watched from inside, lit by three coloured LEDs; 240x320 frames by a physical model.

Stated approximations: the domed gel is a flat one of 18x24 mm bonded to its window, thickness and optics are not
published and are assumptions here, and the contact is linear (the `layer` rung). Young's modulus and Poisson's ratio
are a starting point: sample the modulus where forces matter. No frame of a real DIGIT was used.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerMaterial
from sensors.contact.solver import NO_SURFACE, ContactSolution
from sensors.gel_pad import GelPad
from sensors.optics.gel_leds import Led, LedShader, Membrane

FRAME_SHAPE = (240, 320)
GEL_MM = (18.0, 24.0)
"""Height and width of the gel; the frame shows all of it."""
PIXEL_MM = GEL_MM[1] / FRAME_SHAPE[1]

LEDS = (
    Led(azimuth_deg=90.0, colour=(1.0, 0.15, 0.10)),
    Led(azimuth_deg=210.0, colour=(0.12, 1.0, 0.18)),
    Led(azimuth_deg=330.0, colour=(0.10, 0.18, 1.0)),
)


class DigitParameters(BaseModel):
    """What can be set on a DIGIT; every length and modulus carries its unit in its name."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    gel_thickness_mm: float = Field(3.0, gt=0, description="assumed, see the module")
    gel_modulus_kpa: float = Field(30.0, gt=0, description="Young's modulus")
    gel_poisson: float = Field(0.41, ge=0, le=0.5)
    grid: Literal[64, 80, 160, 320] = Field(160, description="cells along a side of the contact grid (24 mm)")
    leds: tuple[Led, ...] = Field(LEDS, min_length=1)
    membrane: Membrane = Membrane()
    exposure: float = Field(130.0, gt=0, description="grey levels of a white facet that faces one LED in the middle")
    blur_px: float = Field(1.0, ge=0, description="Gaussian blur of the membrane and the lens")
    noise_levels: float = Field(1.0, ge=0, description="standard deviation of a pixel between frames, grey levels")

    @property
    def pad(self) -> GelPad:
        """The gel on its contact grid."""
        material = LayerMaterial(self.gel_thickness_mm * 1e-3, self.gel_modulus_kpa * 1e3, self.gel_poisson)
        return GelPad(Grid(self.grid, GEL_MM[1] * 1e-3), material)


@dataclass(frozen=True)
class DigitPress:
    """One press: contact, displacement (n, n) of the membrane in metres, and the frame (240, 320, 3) uint8 RGB."""

    contact: ContactSolution
    displacement: NDArray[np.floating]
    frame: NDArray[np.uint8]


class Digit:
    """One DIGIT. x runs along the frame's columns, y down its rows; the grid's origin is the middle of the frame."""

    def __init__(self, parameters: DigitParameters | None = None) -> None:
        self.parameters = parameters or DigitParameters()
        self.pad = self.parameters.pad
        self.grid = self.pad.grid
        self.shader = LedShader(self.parameters.leds, self.parameters.membrane, FRAME_SHAPE, PIXEL_MM * 1e-3)

    @cached_property
    def gel(self) -> NDArray[np.bool_]:
        """Cells of the contact grid (n, n) that are gel: the grid is as wide as the gel, and taller."""
        _, y = self.grid.coordinates()
        return np.asarray(np.abs(y) < GEL_MM[0] / 2 * 1e-3)

    def press(
        self,
        gap: NDArray[np.floating],
        *,
        load_n: float | None = None,
        depth_mm: float | None = None,
        rng: np.random.Generator | None = None,
    ) -> DigitPress:
        """Press an object of `gap` (n, n; metres above the gel at first touch, inf where there is none).

        One of load and depth is given; what lies beside the gel touches nothing. Raises ValueError as `GelPad.solve`.
        """
        if gap.shape != self.gel.shape:
            raise ValueError(f"gap must have the grid's shape {self.gel.shape}, got {gap.shape}")
        contact = self.pad.solve(np.where(self.gel, gap, NO_SURFACE), load_n=load_n, depth_mm=depth_mm)
        displacement = self.pad.displacement(contact)
        return DigitPress(contact, displacement, self.frame(displacement, rng))

    def frame(
        self, displacement: NDArray[np.floating] | None, rng: np.random.Generator | None = None
    ) -> NDArray[np.uint8]:
        """Frame (240, 320, 3) uint8 RGB for a displacement (n, n) in metres; None is the untouched gel."""
        levels = self.shader.light(self._seen_surface(displacement)) * np.float32(self.parameters.exposure)
        if rng is not None and self.parameters.noise_levels > 0:
            noise = rng.standard_normal(levels.shape, dtype=np.float32)
            levels += np.float32(self.parameters.noise_levels) * noise
        return np.clip(np.rint(levels), 0, 255).astype(np.uint8)

    def _seen_surface(self, displacement: NDArray[np.floating] | None) -> NDArray[np.float32]:
        rows, columns = FRAME_SHAPE
        if displacement is None:
            return np.zeros(FRAME_SHAPE, np.float32)
        surface = cv2.resize(np.asarray(displacement, np.float32), (columns, columns), interpolation=cv2.INTER_CUBIC)
        first = (columns - rows) // 2
        seen = surface[first : first + rows]
        sigma = self.parameters.blur_px
        return cv2.GaussianBlur(seen, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE) if sigma > 0 else seen
