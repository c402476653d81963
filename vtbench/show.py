"""Pictures of recordings: contact sheet of a dataset, one press in time, sliding recordings side by side."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vtbench.data.fabricslide16 import N_TAXELS, PERIOD_MS, FabricSlide16, load_fabricslide16
from vtbench.data.files import make_folder, write_whole
from vtbench.data.format import META_FILE
from vtbench.data.meta import read_meta
from vtbench.data.public import PUBLIC, data_root
from vtbench.data.reader import Dataset

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, QUIET, PAPER, TINT = "#1d2733", "#6b7785", "#fbfaf7", "#e7eef5"
FORCE_COLOURS, PRESSURE_COLOURS = "GnBu", "magma"


def show(path: Path | str, png: Path | str, *, sample: int | None = None) -> Path:
    """Draw what `path` is into the file `png` and return it.

    A dataset gives its contact sheet, or one press in time when `sample` is given; one of slides gives the forces of
    its kinds of trial, or one trial with its scores against their thresholds; a run gives the contact sheet
    of its first dataset; `fabricslide16`, or a folder that holds it, gives sliding recordings;
    `gelsight_ball_presses`, or a folder that holds it, gives real presses beside rendered ones.

    Raises:
        ValueError: `path` is none of these, or the sample does not exist.
        OSError: `png` cannot be written.
    """
    folder = Path(path)
    inside = sorted(folder.glob(f"datasets/*/{META_FILE}"))
    if (folder / META_FILE).is_file() or inside:
        dataset = folder if (folder / META_FILE).is_file() else inside[0].parent
        if read_meta(dataset).recordings == "slides":
            from vtbench.show_slides import slide_scores, slide_sheet

            return slide_sheet(dataset, png) if sample is None else slide_scores(dataset, sample, png)
        return contact_sheet(dataset, png) if sample is None else force_history(dataset, sample, png)
    if str(path) == "gelsight_ball_presses" or (folder / "gelsight" / "presses.csv").is_file():
        return _ball_presses(folder if folder.is_dir() else None, Path(png))
    if str(path) in PUBLIC or (folder / "data" / "fabric").is_dir():
        recordings = load_fabricslide16(folder if folder.is_dir() else data_root(str(path)))
        return slide_traces(recordings, png)
    raise ValueError(
        f"{path}: nothing to draw; expected a dataset, a run that holds one, or one of {', '.join(PUBLIC.ids())}"
    )


def _ball_presses(root: Path | None, png: Path) -> Path:
    from sensors.gelsight import committed_calibration
    from sensors.gelsight_figure import draw_held_out
    from vtbench.data.gelsight_ball_presses import load_gelsight_ball_presses

    return draw_held_out(load_gelsight_ball_presses(root), committed_calibration(), png)


def contact_sheet(dataset_dir: Path | str, png: Path | str, count: int = 12) -> Path:
    """Draw `count` samples: frame, its difference to the rest frame, forces and, where stored, pressure.

    The samples show different objects, one in three a shallow press where there are any.
    """
    dataset = Dataset.open(dataset_dir, verify="sha256")
    rows = dataset.columns()
    chosen = pick_samples(rows, count)
    images, forces = dataset.images(chosen), dataset.force(chosen)
    rest = dataset.images(chosen, "image_rest") if "image_rest" in dataset.meta.columns else None
    field = next((name for name in ("pressure", "displacement") if name in dataset.meta.truth), None)
    grids = dataset.truth(field, chosen) if field else None
    gain = _gain(images, rest) if rest is not None else 1.0
    panels = 2 + (rest is not None) + (grids is not None)
    with _cards(png, len(chosen), panels, dataset) as cards:
        for place, (sample, (card, axes)) in enumerate(zip(chosen, cards, strict=True)):
            _card_title(card, rows.iloc[sample])
            _picture(next(axes), images[place], "frame")
            if rest is not None:
                change = difference(images[place], rest[place], gain)
                _picture(next(axes), change, f"frame {_MINUS} rest, ×{gain:g}")
            _force_panel(next(axes), forces[place], float(forces.max()), dataset)
            if grids is not None:
                _grid_panel(next(axes), grids[place], str(field))
    return Path(png)


def force_history(dataset_dir: Path | str, sample: int, png: Path | str) -> Path:
    """Draw one press in time: every taxel and their sum, the hold shaded, the moment of the frame marked."""
    dataset = Dataset.open(dataset_dir, verify="sha256")
    if "force_series" not in dataset.meta.columns:
        raise ValueError(f"{dataset.path}: holds no force histories (an imported dataset has none)")
    series = dataset.force_series([sample])[0]
    row = dataset.columns().iloc[sample]
    time_s = np.arange(len(series)) / row["rate_hz"]
    hold = (row["hold_start"] / row["rate_hz"], row["hold_stop"] / row["rate_hz"])
    with page(png, (11.0, 4.9)) as figure:
        heading(figure, _title(row), f"{dataset.meta.name}, sample {sample}: {_details(row)}")
        left, right = figure.subfigures(2, 2, squeeze=False, height_ratios=[0.9, 4.0], width_ratios=[8.4, 2.6])[1]
        axes = left.subplots(gridspec_kw={"left": 0.08, "right": 0.98, "bottom": 0.14, "top": 0.97})
        axes.axvspan(*hold, color=TINT, lw=0, zorder=0)
        axes.text(hold[0], 0.985, " hold", color=QUIET, va="top", transform=axes.get_xaxis_transform())
        axes.axvline(row["image_time_s"], color=INK, lw=0.8, ls=(0, (2, 2)))
        axes.text(row["image_time_s"], 0.985, " frame", color=INK, va="top", transform=axes.get_xaxis_transform())
        axes.plot(time_s, series.sum(axis=1), color=INK, lw=1.6, label="sum of the taxels")
        ranked = np.argsort(series.max(axis=0))[::-1]
        styles = line_styles(series[:, ranked[:_NAMED_TAXELS]], _LINE_SHARE * float(series.sum(axis=1).max()))
        for rank, taxel in enumerate(ranked):
            named = rank < _NAMED_TAXELS
            look = {"color": f"C{rank}", "label": f"taxel {taxel + 1}", "ls": styles[rank]} if named else {}
            axes.plot(time_s, series[:, taxel], **({"color": "#c5ccd4"} | look), lw=1.1, zorder=2 - rank / 100)
        axes.set(xlabel="time [s]", ylabel="force [N]", xlim=(0, time_s[-1]))
        axes.set_ylim(top=1.14 * float(series.sum(axis=1).max()))
        axes.legend(frameon=False, loc="upper left", fontsize=8, labelcolor=INK)
        stacked = {"left": 0.02, "right": 0.95, "bottom": 0.02, "top": 0.93, "hspace": 0.17}
        image, force = right.subplots(2, 1, gridspec_kw=stacked)
        _picture(image, dataset.images([sample])[0], "frame")
        _force_panel(force, dataset.force([sample])[0], float(series.max()), dataset)
    return Path(png)


def line_styles(series: NDArray[np.floating], width: float) -> list[Any]:
    """Matplotlib's line style of each trace of `series` (t, traces): solid, or dashed where others hide it.

    Traces that are on average closer than `width` take turns: the dashes of one fall into the gaps of the others.
    """
    apart = np.abs(series[:, :, None] - series[:, None, :]).mean(axis=0)
    styles: list[Any] = []
    for trace, near in enumerate(apart < width):
        turn, turns = int(near[:trace].sum()), int(near.sum())
        styles.append("-" if turns < 2 else ((turns - turn) % turns * _DASH, (_DASH, (turns - 1) * _DASH)))
    return styles


def slide_traces(recordings: FabricSlide16, png: Path | str, speed: int = -30) -> Path:
    """Draw one recording of each fabric at the same speed [mm/s]: 16 taxels, each minus its mean, stacked."""
    fabrics = sorted(set(recordings.fabric.tolist()))
    shown = [_one_of(recordings, fabric, speed) for fabric in fabrics]
    waves = [series - series.mean(axis=0) for series in (recordings.series[index] for index in shown)]
    step = 6.0 * float(np.median([wave.std() for wave in waves]))
    columns = min(4, len(shown))
    lines = -(-len(shown) // columns)
    with page(png, (3.4 * columns + 0.4, 3.5 * lines + 1.0)) as figure:
        text = f"{len(recordings)} recordings of 16 capacitive taxels; each trace is a taxel's counts minus their mean"
        heading(figure, "FabricSlide16", text)
        body = figure.subfigures(2, 1, squeeze=False, height_ratios=[0.8, 3.5 * lines])[1, 0]
        grid = {"left": 0.05, "right": 0.99, "bottom": 0.14 / lines, "top": 0.94, "wspace": 0.12, "hspace": 0.28}
        places = body.subplots(lines, columns, squeeze=False, gridspec_kw=grid)
        for number, axes in enumerate(places.ravel()):
            if number >= len(shown):
                axes.axis("off")
                continue
            time_s = np.arange(len(waves[number])) * PERIOD_MS * 1e-3
            for taxel, trace in enumerate(waves[number].T):
                axes.plot(time_s, trace / step - taxel, color=_taxel_colour(taxel, N_TAXELS), lw=0.7)
            index = shown[number]
            condition = f"grip {recordings.setting[index]}, {recordings.speed[index]} mm/s".replace("-", _MINUS)
            axes.set_title(recordings.fabric[index], loc="left", fontsize=10, color=INK, fontweight="bold", pad=4)
            axes.set_title(condition, loc="right", fontsize=8, color=QUIET, pad=4)
            axes.set(yticks=[0, -15], yticklabels=["1", "16"], xlim=(0, time_s[-1]), ylim=(-17, 2))
            if number + columns >= len(shown):
                axes.set_xlabel("time [s]")
            if number % columns == 0:
                axes.set_ylabel("taxel")
    return Path(png)


def pick_samples(frame: pd.DataFrame, count: int) -> list[int]:
    """Indices of up to `count` samples: objects spread evenly, every third a shallow press, units in turn."""
    labels = sorted(frame["label"].unique())
    places = np.linspace(0, len(labels) - 1, min(count, len(labels))).round().astype(int)
    chosen: list[int] = []
    for number, place in enumerate(places[i % len(places)] for i in range(count)):
        mine = frame[(frame["label"] == labels[place]) & ~frame.index.isin(chosen)]
        wished = mine[mine["press"] == ("shallow" if number % 3 == 2 else "deep")]
        pool = wished if len(wished) else mine
        units = sorted(pool["unit"].unique())
        if units:
            chosen.append(int(pool.index[pool["unit"] == units[number % len(units)]][0]))
    return chosen


def difference(image: NDArray[np.uint8], rest: NDArray[np.uint8], gain: float) -> NDArray[np.uint8]:
    """Signed difference of two RGB frames, multiplied by `gain`, on middle grey; uint8."""
    change = (image.astype(np.float32) - rest.astype(np.float32)) * gain + 128.0
    return np.clip(np.rint(change), 0, 255).astype(np.uint8)


_MINUS = "\N{MINUS SIGN}"
_NAMED_TAXELS = 5
_DASH = 5.0
_LINE_SHARE = 0.006
"""Width of a line as a share of the largest force shown."""
_GRID_SHOWN = 64
_PANEL_IN, _GAP_IN, _TITLE_IN, _HEADING_IN = 1.7, 0.09, 0.62, 1.05


@contextmanager
def _cards(png: Path | str, count: int, panels: int, dataset: Dataset) -> Iterator[list[tuple[Any, Iterator[Axes]]]]:
    """A page of cards, each a title over a row of square panels, with the dataset's name above them."""
    across = 2 if count > 1 else 1
    lines = -(-count // across)
    card = (panels * (_PANEL_IN + _GAP_IN) + 0.5, _PANEL_IN + _TITLE_IN)
    size = (across * card[0] - 0.2, lines * card[1] + _HEADING_IN + 0.1)
    left, top = 0.16 / card[0], 1 - _TITLE_IN / card[1]
    right = (0.16 + panels * (_PANEL_IN + _GAP_IN) - _GAP_IN) / card[0]
    edges = {"left": left, "right": right, "bottom": top - _PANEL_IN / card[1], "top": top}
    with page(png, size) as figure:
        heading(figure, dataset.meta.name, _summary_line(dataset))
        heights = [_HEADING_IN - _TITLE_IN / 2, *[card[1]] * lines, _TITLE_IN / 2 + 0.1]
        grid = figure.subfigures(lines + 2, across, squeeze=False, height_ratios=heights)
        places = grid[1:-1].ravel()[:count]
        for place in places:
            place.set_facecolor("none")
        wide = {**edges, "wspace": _GAP_IN / _PANEL_IN}
        yield [(place, iter(place.subplots(1, panels, squeeze=False, gridspec_kw=wide)[0])) for place in places]


@contextmanager
def page(png: Path | str, size: tuple[float, float]) -> Iterator[Figure]:
    """A figure of `size` inches, saved as `png` when the block ends; no display and no global state."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    png = Path(png)
    make_folder(png.parent)
    style = {"font.family": "DejaVu Sans", "font.size": 9, "axes.edgecolor": "#c5ccd4", "axes.labelcolor": QUIET}
    ticks = {"xtick.color": QUIET, "ytick.color": QUIET, "axes.spines.top": False, "axes.spines.right": False}
    with rc_context({**style, **ticks}):
        figure = Figure(figsize=size, facecolor=PAPER)
        FigureCanvasAgg(figure)
        yield figure
        save = partial(figure.savefig, dpi=120, format="png", metadata={"Software": "vtbench"})
        write_whole(png, save)


def heading(figure: Figure, title: str, text: str) -> None:
    """Title and a quieter line at the top of a page."""
    inch = 1 / figure.get_figheight()
    left = 0.16 / figure.get_figwidth()
    figure.text(left, 1 - 0.38 * inch, title, fontsize=17, fontweight="bold", color=INK)
    figure.text(left, 1 - 0.66 * inch, text, fontsize=9.5, color=QUIET)


def _card_title(card: Any, row: pd.Series[Any]) -> None:
    height, width = card.bbox.height / card.figure.dpi, card.bbox.width / card.figure.dpi
    level = 1 - (_TITLE_IN - 0.27) / height
    card.text(0.16 / width, level, _title(row), fontsize=11, fontweight="bold", color=INK)
    card.text(1 - (0.34 + _GAP_IN) / width, level, _details(row), fontsize=8.5, color=QUIET, ha="right")


def _title(row: pd.Series[Any]) -> str:
    return str(row["object"]).replace("_", " ").replace("-", " ")


def _details(row: pd.Series[Any]) -> str:
    parts = [f"{row['press']} press", f"unit {row['unit']}", f"session {row['session']}"]
    parts += [f"{row['total_force_n']:.2f} N"] if "total_force_n" in row else []
    parts += [f"{row['indentation_mm']:.1f} mm indentation"] if "indentation_mm" in row else []
    return " · ".join(parts)


def _summary_line(dataset: Dataset) -> str:
    summary = dataset.summary()
    presses = " and ".join(f"{count} {press}" for press, count in summary["presses"].items())
    height, width = summary["image_size"]
    return (
        f"{presses} presses of {summary['objects']} objects, units: {summary['units']}; "
        f"{summary['taxels']} taxels, {height}×{width} frames; dataset {dataset.hash[:12]}"
    )


def _gain(images: NDArray[np.uint8], rest: NDArray[np.uint8]) -> float:
    """How much a difference may be stretched so that nearly all of it stays in range, 1 to 10."""
    change = np.abs(images.astype(np.int16) - rest)
    fit = 127.0 / max(1.0, float(np.percentile(change, 99.7)))
    return max(gain for gain in (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0) if gain <= max(fit, 1.0))


def _picture(axes: Axes, image: NDArray[Any], caption: str) -> None:
    axes.imshow(image, interpolation="antialiased")
    _caption(axes, caption)


def _force_panel(axes: Axes, force: NDArray[np.float32], top: float, dataset: Dataset) -> None:
    """The taxels as they lie, with their numbers; as bars when their layout is not known."""
    from matplotlib.colors import PowerNorm

    sensor = dataset.meta.sensor or {}
    rows = int(sensor.get("taxel_rows", round(len(force) ** 0.5)))
    if rows * (len(force) // rows) != len(force):
        axes.bar(np.arange(len(force)), force, color=_taxel_colour(len(force) // 2, len(force)))
        axes.set_ylim(min(0.0, float(force.min())), top)
        _caption(axes, "taxel force [N]")
        return
    grid = force.reshape(rows, -1)
    axes.imshow(grid, cmap=FORCE_COLOURS, norm=PowerNorm(0.6, 0, max(top, 1e-6), clip=True))
    for (row, column), value in np.ndenumerate(grid):
        colour = "white" if value > 0.5 * top else INK if value > 0.03 * top else "#9aa5b1"
        text = f"{round(float(value), 2) + 0.0:.2f}".replace("-", _MINUS)
        axes.text(column, row, text, ha="center", va="center", fontsize=26 / max(grid.shape), color=colour)
    _caption(axes, "taxel force [N]")


def _grid_panel(axes: Axes, grid: NDArray[Any], field: str) -> None:
    from matplotlib.colors import PowerNorm

    scale, unit = (1e-3, "kPa") if field == "pressure" else (1e3, "mm")
    values = np.asarray(grid, np.float32) * scale
    top = max(float(values.max()), 1e-9)
    pool = max(1, values.shape[0] // _GRID_SHOWN)  # thin rims of contact would vanish in a small picture
    values = _block_max(values, pool)
    axes.imshow(values, cmap=PRESSURE_COLOURS, norm=PowerNorm(0.5, 0, top))
    _caption(axes, f"{field}, peak {top:,.0f} {unit}" if top >= 10 else f"{field}, peak {top:.2g} {unit}")


def _block_max(values: NDArray[np.float32], size: int) -> NDArray[np.float32]:
    rows, columns = values.shape[0] // size, values.shape[1] // size
    blocks = values[: rows * size, : columns * size].reshape(rows, size, columns, size)
    largest: NDArray[np.float32] = blocks.max(axis=(1, 3))
    return largest


def _caption(axes: Axes, text: str) -> None:
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    axes.set_title(text, fontsize=7.5, color=QUIET, pad=3, loc="left")


def _taxel_colour(taxel: int, count: int) -> Any:
    from matplotlib import colormaps

    return colormaps["viridis"](0.05 + 0.85 * taxel / max(1, count - 1))


def _one_of(recordings: FabricSlide16, fabric: str, speed: int) -> int:
    """The recording of a fabric nearest to a speed, at the grip setting nearest to 180."""
    mine = np.flatnonzero(recordings.fabric == fabric)
    distance = np.abs(recordings.speed[mine] - speed) * 1000 + np.abs(recordings.setting[mine] - 180)
    return int(mine[np.argmin(distance)])
