"""Picture of held-out presses: real, rendered, and their difference."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sensors.ball_press import BallPresses
from sensors.gelsight_score import evaluate, render_press, summarise
from sensors.optics.gel import GelCalibration

INK, QUIET, PAPER = "#1d2733", "#6b7785", "#fbfaf7"
_GAIN = 4
_ACROSS = 3


def draw_held_out(data: BallPresses, calibration: GelCalibration, png: Path) -> Path:
    """Draw the contact crop of each held-out press, with its scores, into the file `png` and return it.

    All at one scale; a crop that the frame's edge cuts leaves paper below or beside it.
    Differences are real minus rendered, `_GAIN` times on middle grey.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = evaluate(data, calibration)
    l1, ssim, psnr = summarise(rows)
    lines = -(-len(rows) // _ACROSS)
    figure = Figure(figsize=(_ACROSS * 4.6, 0.6 + lines * 1.75), facecolor=PAPER, layout="constrained")
    FigureCanvasAgg(figure)
    title = (
        f"GelSight, {len(rows)} presses left out of the fit: "
        f"L1 {l1['mean']:.2f}, SSIM {ssim['mean']:.3f}, PSNR {psnr['mean']:.1f} dB "
        f"(untouched frame alone: {l1['rest_mean']:.2f}, {ssim['rest_mean']:.3f}, {psnr['rest_mean']:.1f} dB)"
    )
    figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, color=INK, weight="bold")
    places = figure.subplots(lines, 3 * _ACROSS, squeeze=False).reshape(-1, 3)
    for axes in places[len(rows) :].ravel():
        axes.axis("off")
    across = max(max(picture.shape[:2]) for picture in (press.frame[press.crop()] for press in data.held_out()))
    for row, press, card in zip(rows, data.held_out(), places, strict=False):
        crop = press.crop()
        rendered = render_press(press, data, calibration)[crop]
        difference = press.frame[crop].astype(np.int16) - rendered
        pictures = {
            f"real, press {press.number}": press.frame[crop],
            f"rendered, L1 {row['l1']:.2f}": rendered,
            f"difference ×{_GAIN}": np.clip(128 + _GAIN * difference, 0, 255).astype(np.uint8),
        }
        for axes, (title, picture) in zip(card, pictures.items(), strict=True):
            axes.imshow(picture, interpolation="nearest")
            axes.set(xlim=(-0.5, across - 0.5), ylim=(across - 0.5, -0.5))
            axes.set_title(title, fontsize=8, color=QUIET, loc="left", pad=3)
            axes.axis("off")
    png.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(png, dpi=110, format="png", metadata={"Software": "vtbench"})
    return png
