"""The camera that looks at the inner face of the skin.

Orthographic view of the 80x80 mm region; the surface enters through its slopes only (Lambert). What does not depend on
the surface - light, falloff, cloth, vignette - is worked out once per unit.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sensors.contact.skin import cosine_basis, sine_basis
from sensors.optics.canvas import Canvas
from sensors.optics.dragged_weave import DraggedWeave
from sensors.optics.lights import LedRing
from sensors.optics.noise import normal_table, random_words
from sensors.optics.pixels import expose, shade

View = Literal["region", "native_crop", "full"]


@dataclass(frozen=True)
class CameraParameters:
    """A 1280x720 camera whose centre square shows the whole sensing region.

    `view`: `region` is that square resampled to 256x256 (0.3125 mm a pixel on 80 mm), `native_crop` its central 256x256
    native pixels, `full` the whole 720x1280 frame with the housing at both sides. `shot_noise` and `read_noise` are
    standard deviations in grey levels of a native pixel, at full scale and in the dark.
    """

    view: View = "region"
    exposure: float = 0.36
    vignette: float = 0.20
    shot_noise: float = 2.5
    read_noise: float = 1.0

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the frame."""
        return (NATIVE_ROWS, NATIVE_COLUMNS) if self.view == "full" else (REGION_PIXELS, REGION_PIXELS)


NATIVE_ROWS, NATIVE_COLUMNS = 720, 1280
REGION_PIXELS = 256
_HOUSING_GREY = 12.0


class Camera:
    """Renders frames of one unit; shares nothing that changes between frames."""

    def __init__(
        self,
        parameters: CameraParameters,
        leds: LedRing,
        canvas: Canvas,
        size_m: float,
        n_modes: int,
        rng: np.random.Generator,
        offset_m: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self.parameters = parameters
        pixels = NATIVE_ROWS if parameters.view == "full" else REGION_PIXELS
        span = size_m if parameters.view != "native_crop" else size_m * REGION_PIXELS / NATIVE_ROWS
        relative = ((np.arange(pixels) + 0.5) / pixels - 0.5) * span
        x_m, y_m = relative + offset_m[0], relative + offset_m[1]
        self._across = tuple(basis.astype(np.float32) for basis in _bases(x_m, size_m, n_modes))
        self._down = tuple(basis.astype(np.float32) for basis in _bases(y_m, size_m, n_modes))
        x, y = np.meshgrid(x_m, y_m)
        self._cloth = DraggedWeave(canvas, x_m, y_m, copy.deepcopy(rng))
        cloth = canvas.reflectance(x_m, y_m, rng)
        falloff = 1 - parameters.vignette * (x**2 + y**2) / (2 * (size_m / 2) ** 2)
        light = leds.irradiance(x, y)
        full_scale = 255 * parameters.exposure
        self._facet = np.ascontiguousarray(light * (cloth * falloff)[:, None] * full_scale, np.float32)
        self._flat = np.zeros(x.shape, np.float32)
        averaged = 1.0 if parameters.view != "region" else NATIVE_ROWS / REGION_PIXELS
        read, shot = parameters.read_noise, parameters.shot_noise
        self._noise_variance = (read**2 / averaged**2, shot**2 / 255 / averaged**2)

    def clean(
        self, modes: NDArray[np.floating] | None, gain: NDArray[np.floating] | None = None
    ) -> NDArray[np.float32]:
        """Noise-free frame (3, rows, columns) in grey levels from the sine modes (n, n) of the surface (m); None: flat.

        `gain` scales the three channels (drift of LEDs and exposure over a session).
        """
        channels = np.ones(3, np.float32) if gain is None else np.asarray(gain, np.float32)
        slope_x, slope_y = (self._flat, self._flat) if modes is None else self.slopes(modes)
        return shade(self._facet, slope_x, slope_y, channels)

    def capture(
        self,
        modes: NDArray[np.floating] | None,
        rng: np.random.Generator | None = None,
        gain: NDArray[np.floating] | None = None,
        weave: NDArray[np.floating] | None = None,
    ) -> NDArray[np.uint8]:
        """A frame (rows, columns, 3) uint8 RGB; no sensor noise where `rng` is None, `weave` as by `dragged_weave`."""
        levels = self.clean(modes, gain)
        if weave is not None:
            levels *= np.asarray(weave, np.float32)
        if self.parameters.view == "full":
            levels = _beside_housing(levels)
        read_variance, shot_variance = (0.0, 0.0) if rng is None else self._noise_variance
        return expose(levels, random_words(rng, levels.size), normal_table(), read_variance, shot_variance)

    def shift_shape(self, modes: NDArray[np.floating]) -> NDArray[np.float32]:
        """Values (rows, columns) at the pixels of an in-plane displacement with sine `modes`."""
        modes = np.asarray(modes, np.float32)
        return np.asarray(self._down[0] @ modes @ self._across[0].T)

    def dragged_weave(self, shape: NDArray[np.float32], shift_m: tuple[float, float]) -> NDArray[np.float32] | None:
        """How much brighter each pixel (rows, columns) is once the cloth has moved by `shape` times `shift_m` (x, y).

        None where it has not moved.
        """
        return None if shift_m == (0.0, 0.0) else self._cloth.ratio(shape, shift_m)

    def sheared_weave(self, moved_m: NDArray[np.float32]) -> NDArray[np.float32]:
        """`dragged_weave` where each point of the cloth has moved by its own (x, y): `moved_m` (2, rows, columns)."""
        return self._cloth.ratio_each(np.asarray(moved_m, np.float32))

    def slopes(self, modes: NDArray[np.floating]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Slopes along x and y (rows, columns) at the pixels of a surface with sine `modes`."""
        modes = np.asarray(modes, np.float32)
        sine_x, cosine_x = self._across
        sine_y, cosine_y = self._down
        return sine_y @ modes @ cosine_x.T, cosine_y @ modes @ sine_x.T


def _beside_housing(levels: NDArray[np.float32]) -> NDArray[np.float32]:
    """The whole frame (3, 720, 1280) around its centre square (3, 720, 720); the housing has read noise as well."""
    whole = np.full((3, NATIVE_ROWS, NATIVE_COLUMNS), _HOUSING_GREY, np.float32)
    left = (NATIVE_COLUMNS - NATIVE_ROWS) // 2
    whole[:, :, left : left + NATIVE_ROWS] = levels
    return whole


def _bases(
    position_m: NDArray[np.float64], size_m: float, n_modes: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    relative = position_m / size_m + 0.5
    return sine_basis(relative, n_modes), cosine_basis(relative, n_modes, size_m)
