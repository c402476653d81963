"""Picture of one trial: sixteen force traces, what the contact did, the onset, and frames where there are any."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors.fvsight import TAXELS_PER_SIDE
from sensors.slide.recording import GROSS, PARTIAL, SlideRecording

_STATE_COLOURS = {PARTIAL: "#f6d58a", GROSS: "#f2b5a7"}
_STATE_NAMES = {PARTIAL: "partial slip", GROSS: "gross slip"}
_COLOURS = ("#1b6ca8", "#c8553d", "#2f8f6b", "#7b5aa6", "#b8860b", "#3fa7bf", "#a63d6d", "#5f6b3a")
_QUIET = "0.72"
_LOADED_N = 0.1
"""Taxels that never read more stay grey."""
_LEAST_SLIP_MM = 0.1
_FRAMES = 6
_CHANGE_GAIN = 4.0


def draw_slide(recording: SlideRecording, path: str | Path) -> Path:
    """Draw a trial into an image file; returns its path.

    Traces of loaded taxels have the colours of the key, the array as the camera sees it. With the truth
    `slip_distance` a second panel shows it, `stick_ratio` beside it; with frames a strip stands on top: the first, then
    what changed since.
    """
    rows = [("frames", 1.45)] if recording.frames is not None else []
    rows.append(("force", 3.6))
    if "slip_distance" in recording.truth:
        rows.append(("slip", 1.0))
    figure = _figure(10.5, 1.25 + sum(height for _, height in rows) + 0.25 * len(rows))
    grid = figure.add_gridspec(
        len(rows), 1, height_ratios=[height for _, height in rows], left=0.075, right=0.86, hspace=0.12,
        top=1 - 0.62 / figure.get_figheight(), bottom=0.55 / figure.get_figheight(),
    )  # fmt: skip
    axes = {name: figure.add_subplot(grid[row]) for row, (name, _) in enumerate(rows)}
    shared = [axes[name] for name in ("force", "slip") if name in axes]
    for panel in shared:
        _shade_states(panel, recording)
        panel.set_xlim(0, recording.force_time_s[-1])
        panel.tick_params(labelbottom=panel is shared[-1])
    _draw_forces(axes["force"], recording)
    if "slip" in axes:
        _draw_slip(axes["slip"], recording)
    if "frames" in axes:
        _draw_frames(axes["frames"], recording)
    shared[-1].set_xlabel("time (s)")
    figure.text(0.075, 1 - 0.3 / figure.get_figheight(), _title(recording), fontsize=12, va="center", weight="bold")
    figure.savefig(path, dpi=130)
    return Path(path)


def _title(recording: SlideRecording) -> str:
    about = recording.labels
    parts = [f"{about['object']}, {str(about['kind']).replace('_', ' ')}", f"{about['load_n']:g} N"]
    if about["speed_mm_s"]:
        parts.append(f"{about['speed_mm_s']:g} mm/s towards {about['direction_deg']:g} deg")
    if about["rotation_deg_s"]:
        parts.append(f"{about['rotation_deg_s']:g} deg/s")
    parts.append(f"trial {about['trial']}, unit {about['unit']}")
    return "  ·  ".join(parts)


def _runs(state: NDArray[np.uint8], value: int) -> list[tuple[int, int]]:
    """[first, last) of each stretch of samples in that state."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], (state == value).astype(np.int8), [0]))))
    return [(int(first), int(last)) for first, last in edges.reshape(-1, 2)]


def _shade_states(axes: Any, recording: SlideRecording) -> None:
    for value, colour in _STATE_COLOURS.items():
        for first, last in _runs(recording.state, value):
            axes.axvspan(first / recording.rate_hz, last / recording.rate_hz, color=colour, alpha=0.55, linewidth=0)
    if recording.onset_sample is not None:
        axes.axvline(recording.onset_sample / recording.rate_hz, color="0.1", linewidth=1.2, linestyle=(0, (4, 2)))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="0.92", linewidth=0.8)
    axes.set_axisbelow(True)


def _draw_forces(axes: Any, recording: SlideRecording) -> None:
    from matplotlib.patches import Patch

    time, series = recording.force_time_s, recording.force_series
    loaded = np.flatnonzero(series.max(axis=0) > _LOADED_N)
    by_load = loaded[np.argsort(-series[:, loaded].max(axis=0))]
    colours = {int(taxel): _COLOURS[rank % len(_COLOURS)] for rank, taxel in enumerate(by_load[: len(_COLOURS)])}
    for taxel in range(series.shape[1]):
        colour = colours.get(taxel, _QUIET)
        axes.plot(time, series[:, taxel], color=colour, linewidth=0.9 if taxel in colours else 0.6)
    low, high = float(series.min()), float(series.max())
    axes.set_ylim(low - 0.04 * (high - low), high + 0.1 * (high - low))
    axes.set_ylabel("read-back force (N)")
    if recording.onset_sample is not None:
        axes.annotate(
            f" onset {recording.onset_sample / recording.rate_hz:.3f} s",
            (recording.onset_sample / recording.rate_hz, 0.985), xycoords=("data", "axes fraction"),
            fontsize=9, va="top",
        )  # fmt: skip
    shown = [value for value in _STATE_COLOURS if (recording.state == value).any()]
    handles = [Patch(color=_STATE_COLOURS[value], alpha=0.55, label=_STATE_NAMES[value]) for value in shown]
    if handles:
        axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.005, 0.42), frameon=False, fontsize=9)
    _taxel_key(axes, colours)


def _taxel_key(axes: Any, colours: dict[int, str]) -> None:
    """The array as a 4 x 4 map, its loaded taxels in the colours of their traces."""
    from matplotlib.colors import to_rgb

    key = axes.inset_axes((1.02, 0.56, 0.14, 0.4))
    picture = np.array([to_rgb(colours.get(taxel, "0.93")) for taxel in range(TAXELS_PER_SIDE**2)])
    key.imshow(picture.reshape(TAXELS_PER_SIDE, TAXELS_PER_SIDE, 3), aspect="equal")
    for edge in np.arange(-0.5, TAXELS_PER_SIDE):
        key.axhline(edge, color="white", linewidth=2)
        key.axvline(edge, color="white", linewidth=2)
    for taxel in range(TAXELS_PER_SIDE**2):
        row, column = divmod(taxel, TAXELS_PER_SIDE)
        ink = "white" if taxel in colours else "0.6"
        key.text(column, row, str(taxel), ha="center", va="center", fontsize=8, color=ink)
    key.set_title("taxel", fontsize=9, pad=3)
    key.set_axis_off()


def _draw_slip(axes: Any, recording: SlideRecording) -> None:
    axes.plot(recording.force_time_s, 1e3 * recording.truth["slip_distance"], color="0.2", linewidth=1.2)
    axes.set_ylabel("slid (mm)")
    axes.set_ylim(0, max(1.08e3 * float(recording.truth["slip_distance"].max()), _LEAST_SLIP_MM))
    if "stick_ratio" in recording.truth:
        share = axes.twinx()
        share.plot(recording.force_time_s, recording.truth["stick_ratio"], color=_COLOURS[0], linewidth=1.2)
        share.set_ylim(-0.04, 1.08)
        share.set_ylabel("area that sticks", color=_COLOURS[0])
        share.spines["top"].set_visible(False)


def _draw_frames(axes: Any, recording: SlideRecording) -> None:
    frames = recording.frames
    assert frames is not None
    chosen = np.linspace(0, len(frames) - 1, _FRAMES).round().astype(int)
    axes.set_axis_off()
    width = 1 / _FRAMES
    for place, number in enumerate(chosen):
        panel = axes.inset_axes((place * width + 0.004, 0.0, width - 0.008, 1.0))
        panel.imshow(frames[0] if place == 0 else _change(frames[0], frames[number]), interpolation="antialiased")
        panel.set_axis_off()
        what = "" if place == 0 else f", change x {_CHANGE_GAIN:g}"
        panel.set_title(f"{recording.frame_time_s[number]:.2f} s{what}", fontsize=8, pad=2)


def _change(first: NDArray[np.uint8], later: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Amplified difference of two frames around mid-grey."""
    return np.clip(128 + _CHANGE_GAIN * (later.astype(float) - first), 0, 255).astype(np.uint8)


def _figure(width: float, height: float) -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), facecolor="white")
    FigureCanvasAgg(figure)
    return figure
