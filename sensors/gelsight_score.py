"""Score a calibrated GelSight on real presses that its calibration has not seen."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors.ball_press import BallPress, BallPresses, interval_of_mean
from sensors.gelsight_fit import Candidate, check_scale, press_surface
from sensors.optics.gel import GelCalibration, GelShader
from sensors.optics.image_scores import image_scores

METRICS = ("l1", "ssim", "psnr_db")


def render_press(press: BallPress, data: BallPresses, calibration: GelCalibration) -> NDArray[np.uint8]:
    """The frame (rows, columns, 3) uint8 RGB that the calibrated sensor would show of a real press, without noise."""
    check_scale(data)
    gel = Candidate(gel_thickness_mm=calibration.gel_thickness_mm, gel_poisson=calibration.gel_poisson)
    return GelShader(calibration).render(press_surface(press, data, gel), data.rest)


def evaluate(data: BallPresses, calibration: GelCalibration) -> list[dict[str, Any]]:
    """One row for each held-out press: press, and l1, ssim, psnr_db of its contact crop, rendered and rest frame alone.

    The figures of the untouched frame carry the prefix `rest_`: what a renderer that does nothing scores.
    Raises ValueError where a scored press was fitted on.
    """
    seen = set(calibration.made.get("fitted_presses", []))
    rows = []
    for press in data.held_out():
        if press.number in seen:
            raise ValueError(f"press {press.number} was fitted on; a score on it would say nothing")
        crop = press.crop()
        real = press.frame[crop]
        rendered = image_scores(real, render_press(press, data, calibration)[crop])
        alone = image_scores(real, data.rest[crop])
        row: dict[str, Any] = {"press": press.number}
        row |= {name: getattr(rendered, name) for name in METRICS}
        row |= {f"rest_{name}": getattr(alone, name) for name in METRICS}
        rows.append(row)
    return rows


def summarise(rows: list[dict[str, Any]], level: float = 0.95) -> list[dict[str, Any]]:
    """Mean over presses of each metric beside the rest frame alone; Student's interval, one press one sample."""
    found = []
    for name in METRICS:
        values, alone = [row[name] for row in rows], [row[f"rest_{name}"] for row in rows]
        low, high = interval_of_mean(values, level)
        rest_low, rest_high = interval_of_mean(alone, level)
        found.append(
            {
                "metric": name,
                "mean": float(np.mean(values)),
                "low": low,
                "high": high,
                "rest_mean": float(np.mean(alone)),
                "rest_low": rest_low,
                "rest_high": rest_high,
                "presses": len(rows),
                "interval": f"Student t over presses, {level:.0%}",
            }
        )
    return found
