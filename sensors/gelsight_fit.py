"""Calibrate the GelSight's light on real presses of a ball, and choose its orders on those presses alone.

The surface of each press is solved: the ball is pressed until its contact circle has the published radius. Every choice
(gel thickness, Poisson's ratio, orders, ridge) is made on the mean L1 over presses left out one at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from sensors.ball_press import BallPress, BallPresses
from sensors.contact.grid import Grid
from sensors.gel_pad import press_ball_to_radius
from sensors.gelsight import FRAME_SHAPE, PIXEL_MM, GelSightParameters, rendered_surface
from sensors.optics.gel import GelCalibration, GelShader
from sensors.optics.gel_fit import NormalEquations, fit_rest, gather
from sensors.optics.gel_terms import ShadingRecipe
from sensors.optics.image_scores import ImageScores, image_scores

_TIE = 1.01
"""Candidates this close to the least left-out L1 are taken as equal: a tenth of the standard error of that mean."""


class Candidate(BaseModel):
    """One way to calibrate; `surface` "cap" is the ball's cap cut off at the contact circle, flat beyond it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    surface: Literal["layer", "cap"] = "layer"
    gel_thickness_mm: float = Field(3.0, gt=0)
    gel_poisson: float = Field(0.49, ge=0, le=0.5)
    recipe: ShadingRecipe = ShadingRecipe()
    ridge: float = Field(0.01, ge=0)


def candidates() -> tuple[Candidate, ...]:
    """What is compared: the default, and one thing changed at a time."""
    surfaces: list[dict[str, Any]] = [
        {"surface": "cap"},
        *({"gel_thickness_mm": thickness} for thickness in (2.0, 2.5, 3.5, 4.0, 6.0)),
        {"gel_poisson": 0.45},
    ]
    recipes: list[dict[str, Any]] = [
        *({"normal_degree": degree} for degree in (1, 3, 4, 8)),
        *({"place_degree": degree} for degree in (0, 1, 3)),
        *({"horizons": count} for count in (0, 3, 6, 8, 16)),
        *({"blur_px": sigma} for sigma in (0.5, 2.0)),
    ]
    ridges = [Candidate(ridge=ridge) for ridge in (0.001, 0.003, 0.03)]
    changed = (Candidate(recipe=ShadingRecipe(**change)) for change in recipes)
    return (Candidate(), *(Candidate(**change) for change in surfaces), *changed, *ridges)


def press_surface(press: BallPress, data: BallPresses, candidate: Candidate) -> NDArray[np.float32]:
    """The membrane under a real press, as `rendered_surface` gives it."""
    pixel_m, ball_m = data.pixel_mm * 1e-3, data.ball_radius_mm * 1e-3
    rows, columns = FRAME_SHAPE
    x_m, y_m = ((press.center_x_px + 0.5) - columns / 2) * pixel_m, ((press.center_y_px + 0.5) - rows / 2) * pixel_m
    radius_m = press.contact_radius_px * pixel_m
    parameters = GelSightParameters(gel_thickness_mm=candidate.gel_thickness_mm, gel_poisson=candidate.gel_poisson)
    pad = parameters.pad
    if candidate.surface == "cap":
        return rendered_surface(_cap(Grid(384, pad.grid.size_m), ball_m, radius_m, x_m, y_m))
    return rendered_surface(pad.displacement(press_ball_to_radius(pad, ball_m, radius_m, x_m, y_m)))


def _cap(grid: Grid, ball_m: float, radius_m: float, x_m: float, y_m: float) -> NDArray[np.float64]:
    x, y = grid.coordinates()
    below = np.sqrt(np.maximum(ball_m**2 - (x - x_m) ** 2 - (y - y_m) ** 2, 0))
    return np.maximum(below - np.sqrt(ball_m**2 - radius_m**2), 0)


def leave_one_out(data: BallPresses, candidate: Candidate) -> list[ImageScores]:
    """Scores of each fitted press under the weights of the others, in the order of `data.fitted()`."""
    check_scale(data)
    presses = data.fitted()
    if len(presses) < 2:
        raise ValueError(f"leaving one out needs at least 2 presses whose number divides by 4, got {len(presses)}")
    surfaces = [press_surface(press, data, candidate) for press in presses]
    equations = _equations(data, presses, surfaces, candidate)
    total = sum(equations[1:], equations[0])
    scores = []
    for press, surface, own in zip(presses, surfaces, equations, strict=True):
        shader = GelShader(_calibration(data, candidate, total - own, {}))
        rendered = shader.render(surface, data.rest)
        scores.append(image_scores(press.frame[press.crop()], rendered[press.crop()]))
    return scores


def choose(
    data: BallPresses, among: Sequence[Candidate], progress: bool = False
) -> tuple[Candidate, list[dict[str, Any]]]:
    """The chosen candidate, and the table of all: surface, orders, left-out L1, SSIM and PSNR.

    Chosen is the one with the fewest weights among those within 1 % of the least L1; among equals, the least.
    """
    rows = []
    for candidate in among:
        scores = leave_one_out(data, candidate)
        rows.append(
            {
                **candidate.model_dump(mode="json"),
                "l1": round(float(np.mean([score.l1 for score in scores])), 4),
                "ssim": round(float(np.mean([score.ssim for score in scores])), 4),
                "psnr_db": round(float(np.mean([score.psnr_db for score in scores])), 3),
            }
        )
        if progress:
            print(rows[-1], flush=True)
    bound = _TIE * min(row["l1"] for row in rows)
    near = [index for index, row in enumerate(rows) if row["l1"] <= bound]
    return among[min(near, key=lambda index: (_weights(among[index]), rows[index]["l1"]))], rows


def _weights(candidate: Candidate) -> int:
    return candidate.recipe.n_surface * candidate.recipe.n_place


def fit(data: BallPresses, candidate: Candidate, made: dict[str, Any] | None = None) -> GelCalibration:
    """Calibrate on `data.fitted()`; ValueError for a sensor of another scale, or a bare cap (no gel to render with)."""
    check_scale(data)
    if candidate.surface != "layer":
        raise ValueError("a calibration needs the layer's surfaces: that is what the sensor will render")
    presses = data.fitted()
    surfaces = [press_surface(press, data, candidate) for press in presses]
    equations = _equations(data, presses, surfaces, candidate)
    about = {"fitted_presses": [press.number for press in presses], **(made or {})}
    return _calibration(data, candidate, sum(equations[1:], equations[0]), about)


def check_scale(data: BallPresses) -> None:
    """ValueError where the presses are not from a frame of this sensor's size and scale."""
    if data.rest.shape != (*FRAME_SHAPE, 3) or data.pixel_mm != PIXEL_MM:
        raise ValueError(
            f"expected frames of {FRAME_SHAPE} pixels of {PIXEL_MM} mm, got {data.rest.shape[:2]} of {data.pixel_mm} mm"
        )


def _equations(
    data: BallPresses, presses: Sequence[BallPress], surfaces: Sequence[NDArray[np.float32]], candidate: Candidate
) -> list[NormalEquations]:
    rows, columns = (extent // 2 for extent in FRAME_SHAPE)
    found = []
    for press, surface in zip(presses, surfaces, strict=True):
        down, across = ((whole - seen) // 2 for whole, seen in zip(surface.shape, (rows, columns), strict=True))
        frame = (slice(down, down + rows), slice(across, across + columns))
        crop_rows, crop_columns = (slice(axis.start // 2, (axis.stop + 1) // 2) for axis in press.crop())
        region = (crop_rows, crop_columns)
        found.append(gather(surface, frame, press.frame, data.rest, region, candidate.recipe))
    return found


def _calibration(
    data: BallPresses, candidate: Candidate, equations: NormalEquations, made: dict[str, Any]
) -> GelCalibration:
    recipe = candidate.recipe
    weights = equations.solve(candidate.ridge).reshape(recipe.n_surface, recipe.n_place, 3)
    return GelCalibration(
        sensor="gelsight",
        frame_rows=FRAME_SHAPE[0],
        frame_columns=FRAME_SHAPE[1],
        pixel_mm=data.pixel_mm,
        gel_thickness_mm=candidate.gel_thickness_mm,
        gel_poisson=candidate.gel_poisson,
        recipe=recipe,
        ridge=candidate.ridge,
        weights=_rounded(weights),
        rest=_rounded(fit_rest(data.rest)),
        noise_levels=round(frame_noise(data), 2),
        made=made,
    )


def frame_noise(data: BallPresses) -> float:
    """Standard deviation (grey levels) of a pixel between frames, from the fitted presses.

    The difference of horizontal neighbours, pressed minus untouched, more than two crop half-sides from the contact:
    what the gel does there is smooth, so only the noise of four pixels is left. Neighbours of a real camera are not
    independent (demosaicing, compression): a lower bound.
    """
    spreads = []
    for press in data.fitted():
        change = press.frame.astype(np.float64) - data.rest
        step = np.diff(change, axis=1)
        y, x = np.ogrid[: step.shape[0], : step.shape[1]]
        distance = np.hypot(x - press.center_x_px, y - press.center_y_px)
        far = step[distance > 4.4 * press.contact_radius_px]
        spreads.append(np.sqrt((far**2).mean() / 4))
    return float(np.median(spreads))


def _rounded(values: NDArray[np.float64]) -> list[list[list[float]]]:
    return [[[float(f"{value:.6g}") for value in row] for row in page] for page in values.tolist()]
