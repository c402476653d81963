"""Ridge regression of the light on a gel, gathered press by press so that leaving one out costs a small solve."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sensors.optics.gel import CHANNELS, chebyshev_grids
from sensors.optics.gel_terms import Frame, ShadingRecipe, place_terms, surface_terms

_DARKEST = 4.0
"""Grey levels below which a rest pixel says nothing about relative light."""


@dataclass(frozen=True)
class NormalEquations:
    """Gram (terms, terms) and moment (terms, 3) of pixels; sums of presses are sums of these."""

    gram: NDArray[np.float64]
    moment: NDArray[np.float64]

    def __add__(self, other: NormalEquations) -> NormalEquations:
        return NormalEquations(self.gram + other.gram, self.moment + other.moment)

    def __sub__(self, other: NormalEquations) -> NormalEquations:
        return NormalEquations(self.gram - other.gram, self.moment - other.moment)

    def solve(self, ridge: float) -> NDArray[np.float64]:
        """Weights (terms, 3); `ridge` is relative to each term's own sum of squares, so units do not matter."""
        scale = np.sqrt(np.maximum(np.diag(self.gram), 0))
        scale = np.where(scale > 0, scale, 1.0)
        unit = self.gram / scale / scale[:, None]
        # the unit gram's diagonal is one: a little is always added, so that absent terms get no weight
        regular = unit + max(ridge, 1e-9) * np.eye(len(unit))
        return np.linalg.solve(regular, self.moment / scale[:, None]) / scale[:, None]


def gather(
    height_px: NDArray[np.floating],
    frame: Frame,
    real: NDArray[np.uint8],
    rest: NDArray[np.uint8],
    region: Frame,
    recipe: ShadingRecipe,
    step: int = 2,
) -> NormalEquations:
    """Equations of one press: every `step`-th pixel of `region` of the half-size frame.

    `height_px` is a surface on every other pixel (see `GelShader.relative_change`), `frame` the camera's view in it,
    `real` and `rest` (rows, columns, 3) the pressed and the untouched frame.
    """
    rows, columns = real.shape[0] // 2, real.shape[1] // 2
    pressed, untouched = (
        cv2.resize(image.astype(np.float32), (columns, rows), interpolation=cv2.INTER_AREA) for image in (real, rest)
    )
    change = (pressed - untouched) / np.maximum(untouched, _DARKEST)
    sparse = (slice(region[0].start, region[0].stop, step), slice(region[1].start, region[1].stop, step))
    surface = surface_terms(height_px, recipe, frame)[(slice(None), *sparse)]
    place = place_terms((rows, columns), recipe)[(slice(None), *sparse)]
    terms = (surface[:, None] * place[None]).reshape(len(surface) * len(place), -1).astype(np.float64)
    target = change[sparse].reshape(-1, CHANNELS).astype(np.float64)
    return NormalEquations(terms @ terms.T, terms @ target)


def fit_rest(rest: NDArray[np.uint8], degree: int = 6) -> NDArray[np.float64]:
    """Chebyshev coefficients (3, degree + 1, degree + 1) of a rest frame, least squares in grey levels."""
    rows, columns = rest.shape[:2]
    down, across = (np.linalg.pinv(grid) for grid in chebyshev_grids(rows, columns, degree))
    return np.einsum("ir,jk,rkc->cij", down, across, rest.astype(np.float64))
