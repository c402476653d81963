"""Linen canvas seen from inside: a plain weave with threads that differ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Canvas:
    """Thread pitch (m), contrast of the weave, spread of the threads' brightness and the cloth's colour (RGB)."""

    thread_pitch_m: float = 0.7e-3
    weave_contrast: float = 0.25
    thread_spread: float = 0.06
    colour: tuple[float, float, float] = (0.92, 0.87, 0.78)

    def reflectance(
        self,
        x_m: NDArray[np.float64],
        y_m: NDArray[np.float64],
        rng: np.random.Generator,
        oversampling: int = 4,
    ) -> NDArray[np.float32]:
        """Diffuse reflectance (3, len(y), len(x)) averaged over the pixels centred on `x_m`, `y_m` (m).

        Warp runs along y, weft along x; `rng` draws each thread's brightness and the phase of the weave.
        """
        fine = self.weave(x_m, y_m, rng, oversampling)
        shape = (len(y_m), oversampling, len(x_m), oversampling)
        pattern = fine.reshape(shape).mean(axis=(1, 3))
        return (np.asarray(self.colour)[:, None, None] * pattern).astype(np.float32)

    def weave(
        self, x_m: NDArray[np.float64], y_m: NDArray[np.float64], rng: np.random.Generator, oversampling: int = 4
    ) -> NDArray[np.float64]:
        """Brightness of the cloth without its colour at `oversampling` points across each pixel; see `reflectance`."""
        phase = rng.uniform(0, 2 * self.thread_pitch_m, 2)
        fine_x = _subpixels(x_m, oversampling) + phase[0]
        fine_y = _subpixels(y_m, oversampling) + phase[1]
        warp = 1 + self.thread_spread * _per_thread(fine_x, self.thread_pitch_m, rng)
        weft = 1 + self.thread_spread * _per_thread(fine_y, self.thread_pitch_m, rng)
        across_x = np.cos(np.pi * fine_x / self.thread_pitch_m)
        across_y = np.cos(np.pi * fine_y / self.thread_pitch_m)
        # a plain weave: warp on top where the product is positive, weft where it is negative
        over = across_x[None, :] * across_y[:, None]
        top = 0.5 * (1 + over) * warp[None, :] + 0.5 * (1 - over) * weft[:, None]
        gap = np.abs(np.sin(np.pi * fine_x / self.thread_pitch_m))[None, :] ** 4
        gap = np.maximum(gap, np.abs(np.sin(np.pi * fine_y / self.thread_pitch_m))[:, None] ** 4)
        return np.asarray(top * (1 - self.weave_contrast * gap))


def _subpixels(centres: NDArray[np.float64], oversampling: int) -> NDArray[np.float64]:
    pitch = centres[1] - centres[0]
    offsets = ((np.arange(oversampling) + 0.5) / oversampling - 0.5) * pitch
    return (centres[:, None] + offsets).ravel()


def _per_thread(position: NDArray[np.float64], pitch: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """One standard normal value for each thread, repeated along it."""
    index = np.floor(position / pitch).astype(int)
    index -= index.min()
    return rng.standard_normal(int(index.max()) + 1)[index]
