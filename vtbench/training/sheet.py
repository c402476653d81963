"""A contact sheet of training shapes, each beside what a camera sees of its press."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sensors.fvsight import FVSightUnit
from sensors.objects.gallery import shade
from vtbench.tasks.presses import change
from vtbench.training.presses import FIRST_UNIT, SENSOR, press_shape
from vtbench.training.shapes import shape

COLUMNS, ROWS = 10, 4
CONTRAST = 10
_LOAD_N = 5.0


def draw_sheet(path: Path) -> Path:
    """Draw the first forty shapes, 80 x 80 mm each, above the change of the frame (x10) at 5 N; returns `path`."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    unit = FVSightUnit(SENSOR, FIRST_UNIT)
    figure = Figure(figsize=(1.3 * COLUMNS, 2.72 * ROWS + 0.4), facecolor="white")
    FigureCanvasAgg(figure)
    grid = figure.subplots(2 * ROWS, COLUMNS)
    for number in range(COLUMNS * ROWS):
        row, column = divmod(number, COLUMNS)
        seen = press_shape(
            unit, number, (0.0, 0.0, 0.0), _LOAD_N, np.random.default_rng(number), np.random.default_rng(0)
        )
        heights = 1e3 * shape(number).placed(256, unit.grid.size_m, (0.0, 0.0, 0.0))
        difference = change(seen["frame"], seen["rest"]).astype(np.int16) - 128
        grid[2 * row, column].imshow(shade(heights, 80 / 256))
        grid[2 * row + 1, column].imshow(np.clip(128 + CONTRAST * difference, 0, 255).astype(np.uint8))
        grid[2 * row, column].set_title(str(number), fontsize=7, pad=2)
    for axes in grid.flat:
        axes.set_axis_off()
    figure.suptitle(
        f"Training shapes 0 to {COLUMNS * ROWS - 1} (2k and 2k + 1 are twins), 80 x 80 mm, "
        f"and the change of the frame at {_LOAD_N:g} N, x{CONTRAST}",
        fontsize=10,
        y=0.995,
    )
    figure.subplots_adjust(left=0.005, right=0.995, bottom=0.005, top=0.955, wspace=0.05, hspace=0.14)
    figure.savefig(path, dpi=110)
    return path
