"""Pictures of the objects: shaded relief in height colours with a scale bar."""

from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors.objects.household import get, names
from sensors.objects.raster import place

_REGION_MM = 80.0
_PIXELS = 512
_COLUMNS = 7
_TABLE = np.array([0.96, 0.955, 0.945])
_COLOURS = ["#26355e", "#2b6a8f", "#4a9f8e", "#a9c574", "#f0cf6a", "#f4ad62"]


def draw_gallery(path: str | Path) -> Path:
    """Draw every object as the skin meets it, 80 x 80 mm a panel, into an image file; returns its path."""
    every = names()
    rows = -(-len(every) // _COLUMNS)
    figure = _figure(2.3 * _COLUMNS, 2.62 * rows + 0.55)
    grid = figure.subplots(rows, _COLUMNS)
    for axes in grid.flat:
        axes.set_axis_off()
    for axes, name in zip(grid.flat, every, strict=False):
        _panel(axes, name, _PIXELS)
    for axes in grid.flat[len(every) :][:1]:
        _key(axes)
    figure.suptitle("Household objects: the 80 x 80 mm under the skin", fontsize=15, y=0.985)
    figure.subplots_adjust(left=0.01, right=0.99, bottom=0.01, top=0.915, wspace=0.05, hspace=0.2)
    return _save(figure, path, dpi=150)


def draw_object(name: str, path: str | Path) -> Path:
    """Draw one object from above, with its height profile along x, into an image file; returns its path."""
    thing = get(name)
    figure = _figure(5.6, 7.6)
    top, side = figure.subplots(2, 1, height_ratios=(4.76, 1.2))
    top.set_axis_off()
    _panel(top, name, 2 * _PIXELS)
    heights = 1e3 * place(name, _PIXELS, 1e-3 * _REGION_MM, 0.0, 0.0, 0.0)
    x = (np.arange(_PIXELS) + 0.5) * _REGION_MM / _PIXELS - 0.5 * _REGION_MM
    side.fill_between(x, heights.max(axis=0), color="0.88", linewidth=0, label="highest over y")
    side.plot(x, heights[_PIXELS // 2], color="#a8402d", linewidth=1.2, label="along y = 0")
    side.set(xlabel="x (mm)", ylabel="height (mm)", xlim=(x[0], x[-1]), ylim=(0.0, 1.45 * heights.max()))
    side.legend(frameon=False, fontsize=8, loc="upper center", ncols=2)
    figure.text(0.12, 0.975, fill(thing.description, 66), fontsize=9, va="top")
    figure.subplots_adjust(left=0.12, right=0.97, bottom=0.08, top=0.9, hspace=0.08)
    return _save(figure, path, dpi=150)


def shade(heights_mm: NDArray[np.float32], pitch_mm: float) -> NDArray[np.float64]:
    """RGB image (n, n, 3) in [0, 1] of a heightfield: height colours, lit low from the upper left."""
    from scipy.ndimage import gaussian_filter

    slope_y, slope_x = np.gradient(heights_mm.astype(float), pitch_mm)
    normal = np.stack([-slope_x, -slope_y, np.ones_like(slope_x)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    light = np.array([-0.5, -0.6, 0.75])
    lit = np.clip(normal @ (light / np.linalg.norm(light)), 0.0, 1.0)
    top = max(float(heights_mm.max()), 1e-9)
    share = heights_mm / top
    colour = _colours(share)
    table = np.clip(heights_mm / min(0.3, top), 0.0, 1.0)[..., None]
    base = (1.0 - table) * _TABLE + table * colour
    buried = np.clip(gaussian_filter(heights_mm, 2.0 / pitch_mm) - heights_mm, 0.0, None) / top
    shadow = 1.0 - 0.75 * np.clip(buried, 0.0, 0.8)
    return np.asarray(np.clip(base * (0.45 + 0.78 * lit)[..., None] * shadow[..., None], 0.0, 1.0))


def _colours(share: NDArray[Any]) -> NDArray[np.float64]:
    from matplotlib.colors import LinearSegmentedColormap

    return np.asarray(LinearSegmentedColormap.from_list("height", _COLOURS)(share)[..., :3])


def _key(axes: Any) -> None:
    """The colour key, in a panel of its own."""
    strip = _colours(np.linspace(0.0, 1.0, 256))[None]
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0), aspect="equal")
    axes.imshow(strip, extent=(0.12, 0.88, 0.46, 0.54), aspect="equal", interpolation="bilinear")
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    axes.text(0.12, 0.43, "table", ha="left", va="top", fontsize=9)
    axes.text(0.88, 0.43, "its top", ha="right", va="top", fontsize=9)
    axes.text(0.5, 0.57, "height", ha="center", va="bottom", fontsize=9)


def _panel(axes: Any, name: str, pixels: int) -> None:
    heights = 1e3 * place(name, pixels, 1e-3 * _REGION_MM, 0.0, 0.0, 0.0)
    axes.imshow(
        shade(heights, _REGION_MM / pixels),
        extent=(0.0, _REGION_MM, _REGION_MM, 0.0),
        interpolation="antialiased",
    )
    axes.plot([4.0, 24.0], [76.0, 76.0], color="0.15", linewidth=2.0, solid_capstyle="butt")
    axes.text(14.0, 74.5, "20 mm", ha="center", va="bottom", fontsize=7, color="0.15")
    axes.text(76.5, 76.8, f"{get(name).size_mm[2]:g} mm high", ha="right", va="bottom", fontsize=7, color="0.15")
    axes.set_title(get(name).title, fontsize=10, pad=3)


def _figure(width: float, height: float) -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def _save(figure: Any, path: str | Path, dpi: int) -> Path:
    figure.savefig(path, dpi=dpi, format="png")
    return Path(path)
