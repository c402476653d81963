"""GelSight: a gel on a window, watched through it; 480x640 frames calibrated on real presses of a ball.

Contact: the `layer` rung, linear; the real presses go to half the gel's thickness, where it is no more than a smooth
guess outside the contact. Light: `sensors.optics.gel`, fitted on real presses of one sensor; the calibration beside
this file says which and how. Thickness and Poisson's ratio are those that rendered presses left out of the fit best
among a few; they are not measured. No forces were published with the presses: the modulus is an assumption, and so is
the load that belongs to a depth.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerMaterial
from sensors.contact.solver import ContactSolution
from sensors.gel_pad import GelPad
from sensors.optics.gel import GelCalibration, GelShader

CALIBRATION = Path(__file__).with_name("gelsight_calibration.json")
FRAME_SHAPE = (480, 640)
PIXEL_MM = 0.0295
_SURFACE = 384
"""Points along a side of the surface that is rendered, one every second pixel: 2 mm more than the frame all round."""


class GelSightParameters(BaseModel):
    """What can be set on a GelSight; every length and modulus carries its unit in its name."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    gel_thickness_mm: float = Field(3.0, gt=0)
    gel_modulus_kpa: float = Field(150.0, gt=0, description="Young's modulus; assumed, see the module")
    gel_poisson: float = Field(0.49, ge=0, le=0.5)
    grid: Literal[96, 192, 384] = Field(192, description="cells along a side of the contact grid (22.7 mm)")
    camera_noise: bool = True

    @property
    def pad(self) -> GelPad:
        """The gel on its contact grid."""
        material = LayerMaterial(self.gel_thickness_mm * 1e-3, self.gel_modulus_kpa * 1e3, self.gel_poisson)
        return GelPad(Grid(self.grid, 2 * _SURFACE * PIXEL_MM * 1e-3), material)


@dataclass(frozen=True)
class GelPress:
    """One press: contact, displacement (n, n) of the membrane in metres, and the frame (rows, columns, 3) uint8 RGB."""

    contact: ContactSolution
    displacement: NDArray[np.floating]
    frame: NDArray[np.uint8]


class GelSight:
    """One GelSight. Building it costs tens of milliseconds: reuse it.

    `rest` is the unit's untouched frame (480, 640, 3) uint8 RGB; without one it is the smooth light of the calibrated
    unit. `calibration` is by default the committed one. x runs along the frame's columns, y down its rows; the grid's
    origin is the middle of the frame.
    """

    def __init__(
        self,
        parameters: GelSightParameters | None = None,
        calibration: GelCalibration | None = None,
        rest: NDArray[np.uint8] | None = None,
    ) -> None:
        self.parameters = parameters or GelSightParameters()
        self.shader = GelShader(calibration or committed_calibration())
        self.pad = self.parameters.pad
        self.grid = self.pad.grid
        self.rest = self.shader.calibration.rest_frame() if rest is None else rest
        if self.rest.shape != (*FRAME_SHAPE, 3) or self.rest.dtype != np.uint8:
            raise ValueError(
                f"rest must be a uint8 frame of shape {(*FRAME_SHAPE, 3)}, got {self.rest.dtype} {self.rest.shape}"
            )

    def press(
        self,
        gap: NDArray[np.floating],
        *,
        load_n: float | None = None,
        depth_mm: float | None = None,
        rng: np.random.Generator | None = None,
    ) -> GelPress:
        """Press an object of `gap` (n, n; metres above the gel at first touch, inf where there is none).

        One of load and depth is given. Raises ValueError as `GelPad.solve` does.
        """
        contact = self.pad.solve(gap, load_n=load_n, depth_mm=depth_mm)
        displacement = self.pad.displacement(contact)
        return GelPress(contact, displacement, self.frame(displacement, rng))

    def frame(
        self, displacement: NDArray[np.floating] | None, rng: np.random.Generator | None = None
    ) -> NDArray[np.uint8]:
        """Frame (480, 640, 3) uint8 RGB for a displacement (n, n) in metres; None is the untouched gel."""
        noise = rng if self.parameters.camera_noise else None
        height = None if displacement is None else rendered_surface(displacement)
        return self.shader.render(height, self.rest, noise)

    @cached_property
    def pixel_m(self) -> float:
        """Edge of a pixel on the gel, in metres."""
        return self.shader.calibration.pixel_mm * 1e-3


def rendered_surface(displacement: NDArray[np.floating]) -> NDArray[np.float32]:
    """The membrane (n, n; metres) as the shader wants it: (384, 384), one value every second pixel, in that unit."""
    height = np.asarray(displacement, np.float32) / np.float32(2 * PIXEL_MM * 1e-3)
    if len(height) == _SURFACE:
        return height
    return cv2.resize(height, (_SURFACE, _SURFACE), interpolation=cv2.INTER_CUBIC)


@lru_cache(maxsize=1)
def committed_calibration() -> GelCalibration:
    """The calibration that comes with the package."""
    return GelCalibration.load(CALIBRATION)
