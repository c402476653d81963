"""Pictures of the calibration experiments: loading loop, standard weights, transients of Velostat, ghosts of scans."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors.calibration import (
    GRAVITY,
    RATE_N_PER_S,
    SCANS,
    TAXELS,
    TOP_N,
    VELOSTAT_RANGES,
    WEIGHTS_G,
    Loop,
    ghosts,
    hold_and_release,
)
from sensors.electronics.piezoresistive import PiezoresistiveChain

Array = NDArray[np.float64]

INK, QUIET, BAND = "#1d2733", "#6b7785", "#e9dcc3"
BLUE, RED, GREEN, VIOLET = "#1b6ca8", "#c8553d", "#2f8f6b", "#7b5aa6"
_HOLD_S, _AFTER_S = 4.0, 2.0


def draw_loop(loop: Loop, preset: str, png: Path) -> None:
    """Load and reading in time, the loop itself, and the gap between its branches."""
    figure, (time, whole, gap) = _panels(
        f"Loading and unloading at {RATE_N_PER_S:g} N/s, preset {preset}", 3, 12.6, 4.0
    )
    load, up, down = loop.branches
    turn = float(loop.time_s[loop.load_n.argmax()])
    time.plot(loop.time_s[::50], loop.force_n[::50], color=BLUE, linewidth=0.8, label="read back")
    time.plot(loop.time_s[::50], loop.load_n[::50], color=INK, linewidth=1.0, linestyle=(0, (4, 3)), label="applied")
    time.set(xlabel="time (s)", ylabel="force (N)", xlim=(0, 2 * turn), ylim=(0, 1.08 * TOP_N))
    time.legend(frameon=False, fontsize=9, loc="upper left")
    whole.plot([0, TOP_N], [0, TOP_N], color="0.75", linewidth=0.8)
    whole.plot(load, up, color=BLUE, linewidth=1.6, label="loading")
    whole.plot(load, down, color=RED, linewidth=1.6, label="unloading")
    whole.set(xlabel="applied force (N)", ylabel="read-back force (N)", xlim=(0, TOP_N), ylim=(0, 1.08 * TOP_N))
    whole.legend(frameon=False, fontsize=9, loc="upper left")
    gap.axhline(0, color="0.75", linewidth=0.8)
    gap.plot(load, up - load, color=BLUE, linewidth=1.3, label="loading")
    gap.plot(load, down - load, color=RED, linewidth=1.3, label="unloading")
    width = down - up
    most = int(width.argmax())
    gap.annotate("", (load[most], (down - load)[most]), (load[most], (up - load)[most]),
                 arrowprops={"arrowstyle": "<->", "color": INK, "linewidth": 1.0})  # fmt: skip
    gap.set_title(
        f"largest gap {width[most]:.2f} N, {100 * width[most] / TOP_N:.2f} % of {TOP_N:g} N", fontsize=10, color=QUIET
    )
    gap.set(xlabel="applied force (N)", ylabel="read-back less applied (N)", xlim=(0, TOP_N))
    gap.legend(frameon=False, fontsize=9, loc="best")
    _save(figure, png)


def draw_weights(readings: Array, preset: str, png: Path) -> None:
    """Every weight on every taxel, with the standard deviation of its placings; the line is the true weight."""
    figure, (axes,) = _panels(f"Standard weights on each of {TAXELS} taxels, preset {preset}", 1, 8.6, 4.6)
    places = np.arange(readings.shape[1])
    for number, (grams, colour) in enumerate(zip(WEIGHTS_G, (VIOLET, GREEN, RED, BLUE), strict=True)):
        true = grams * 1e-3 * GRAVITY
        mean, error = readings[number].mean(axis=1), readings[number].std(axis=1, ddof=1)
        axes.axhline(true, color=colour, linewidth=0.9, alpha=0.6)
        axes.errorbar(places, mean, error, color=colour, fmt="o", markersize=4.5, elinewidth=1.0, capsize=2)
        spread = 100 * mean.std(ddof=1) / mean.mean()
        axes.annotate(
            f"{grams} g = {true:.3f} N\nspread {spread:.1f} %", (1.01, true), xycoords=("axes fraction", "data"),
            fontsize=9, color=colour, va="center",
        )  # fmt: skip
    axes.set(xlabel="taxel", ylabel="read-back force (N)", yscale="log", xticks=places, ylim=(0.1, 3.6))
    axes.set_yticks([0.2, 0.5, 1.0, 2.0], ["0.2", "0.5", "1", "2"])
    axes.minorticks_off()
    _save(figure, png)


def draw_transients(chain: PiezoresistiveChain, measured: dict[str, float], png: Path) -> None:
    """Resistance on a hold and after release, conductance against load, and the measures in their ranges."""
    figure, (hold, release, power, ranges) = _panels(
        "Preset velostat beside what public recordings of Velostat show (shaded)", 4, 15.6, 4.2, (1, 1, 0.85, 1.15)
    )
    fall = [1 - percent / 100 for percent in VELOSTAT_RANGES["fall of R in the first second of a hold (%)"]]
    late = [1 + percent / 100 for percent in VELOSTAT_RANGES["R above R0 1 s after release (%)"]]
    hold.fill_between([0.95, 1.05], *fall, color=BAND, linewidth=0)
    release.fill_between([0, 0.06], *VELOSTAT_RANGES["R / R0 at release"], color=BAND, linewidth=0)
    release.fill_between([0.95, 1.05], *late, color=BAND, linewidth=0)
    for force_n, colour in zip((2.0, 5.0, 20.0), (GREEN, BLUE, RED), strict=True):
        time, ratio = hold_and_release(chain, force_n, _HOLD_S, _AFTER_S)
        held, free = (time >= 0) & (time < _HOLD_S - 1e-9), time >= _HOLD_S - 1e-9
        hold.plot(time[held], ratio[held] / ratio[held][0], color=colour, linewidth=1.5, label=f"{force_n:g} N")
        release.plot(time[free] - _HOLD_S, ratio[free], color=colour, linewidth=1.5)
    hold.set(xlabel="time since the press (s)", ylabel="R / R just pressed", xlim=(0, _HOLD_S), ylim=(0.7, 1.01))
    hold.legend(frameon=False, fontsize=9, title="load", title_fontsize=9, loc="upper right")
    release.axhline(1, color="0.6", linewidth=0.8)
    release.set(xlabel="time since the release (s)", ylabel="R / R at rest", xlim=(0, _AFTER_S), ylim=(0.98, 1.42))

    loads = np.geomspace(1, TOP_N, 25)
    added = np.array([1 / hold_and_release(chain, float(load), 1.0, 0.0)[1][-1] - 1 for load in loads])
    middle = float(np.exp(np.log(loads).mean()))
    at_middle = float(np.interp(np.log(middle), np.log(loads), added))
    slopes = [at_middle * (loads / middle) ** k for k in VELOSTAT_RANGES["exponent k of G ~ F^k"]]
    power.fill_between(loads, *slopes, color=BAND, linewidth=0)
    power.plot(loads, added, color=BLUE, linewidth=1.6)
    power.set(xscale="log", yscale="log", xlabel="load (N)", ylabel="conductance added / at rest", xlim=(1, TOP_N))
    power.set_xticks([1, 3, 10, 30], ["1", "3", "10", "30"])
    power.set_yticks([1, 3, 10, 30], ["1", "3", "10", "30"])
    power.minorticks_off()
    _draw_ranges(ranges, measured)
    _save(figure, png)


def _draw_ranges(axes: Any, measured: dict[str, float]) -> None:
    """Each measure as a dot on its own scale, from 0 to twice the middle of its range."""
    for row, (name, value) in enumerate(measured.items()):
        low, high = VELOSTAT_RANGES[name]
        centre = (low + high) / 2
        axes.fill_betweenx([row - 0.2, row + 0.2], low / centre / 2, high / centre / 2, color=BAND, linewidth=0)
        axes.plot(value / centre / 2, row, "o", color=BLUE if low <= value <= high else RED, markersize=6)
        axes.text(0, row - 0.3, name, fontsize=9, color=INK, va="bottom")
        axes.text(1.0, row, f"{value:.3g}  ({low:g} to {high:g})", fontsize=9, color=QUIET, va="center")
    axes.set(xlim=(0, 1.0), ylim=(len(measured) - 0.4, -0.9))
    axes.set_axis_off()


def draw_ghosts(chain: PiezoresistiveChain, errors: list[dict[str, Any]], png: Path) -> None:
    """One press of three corners of a rectangle as every scan reads it, nominal taxels without noise."""
    load = np.zeros((1, TAXELS))
    load[0, [0, 3, 12]] = 10.0
    load[0, 5] = 3.0
    figure, panels = _panels("Crosstalk: the same press through four ways to scan the array", 1 + len(SCANS), 13.6, 3.5)
    pictures = [("true load", load, "")]
    for (name, scanning, correct), row in zip(SCANS, errors, strict=True):
        note = f"RMS error over presses {row['rms_n']:.2g} N"
        pictures.append((name, ghosts(chain, scanning, correct, load), note))
    for axes, (name, forces, note) in zip(panels, pictures, strict=True):
        axes.imshow(forces.reshape(4, 4), cmap="Blues", vmin=0, vmax=10)
        for taxel, value in enumerate(forces[0]):
            shade = "white" if value > 5.5 else INK
            y, x = divmod(taxel, 4)
            axes.text(x, y, f"{value:.1f}".replace("-0.0", "0.0"), ha="center", va="center", fontsize=9, color=shade)
        axes.set_title(name, fontsize=10, color=INK)
        axes.set_xlabel(note, fontsize=9, color=QUIET)
        axes.set(xticks=[], yticks=[])
        axes.grid(visible=False)
        axes.spines[["left", "bottom"]].set_visible(False)
    _save(figure, png)


def _panels(title: str, count: int, width: float, height: float, ratios: tuple[float, ...] | None = None) -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title, x=0.01, ha="left", fontsize=12, color=INK, weight="bold")
    panels = figure.subplots(1, count, squeeze=False, width_ratios=ratios)[0]
    for axes in panels:
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(color="0.93", linewidth=0.8)
        axes.set_axisbelow(True)
        axes.tick_params(labelsize=9)
    return figure, panels


def _save(figure: Any, png: Path) -> None:
    figure.savefig(png, dpi=130, format="png", metadata={"Software": "vtbench"})
