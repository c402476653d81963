"""Error against speed: one panel a protocol, one mark a backbone and method."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from vtbench.backbones.scores import Score

_COLOURS = ("#b3462f", "#2b6a8f", "#3f8f5f", "#8a6bb0", "#a98a2e")
_MARKS = "osD^vP"
_LEAST_ERROR = 0.1
"""Percent; errors below it stand on this line of the logarithmic axis."""
_MS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
"""Labelled milliseconds."""


def draw_error_against_speed(path: Path, found: Sequence[Score], ms_of: Mapping[str, float]) -> Path:
    """Draw error (%, logarithmic, with its interval) against milliseconds of a frame, `ms_of` by backbone; `path` back.

    The time of a mark is backbone plus classifier; a backbone without a time is left out. ValueError where there is no
    score.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import FixedLocator, NullLocator

    found = [score for score in found if score.backbone in ms_of]
    protocols = list(dict.fromkeys(score.protocol for score in found))
    if not protocols:
        raise ValueError("expected scores of image or image-change alone, found none")
    backbones = sorted({score.backbone for score in found})
    methods = sorted({score.method for score in found})
    columns = min(4, math.isqrt(len(protocols) - 1) + 1)
    rows = -(-len(protocols) // columns)
    figure = Figure(figsize=(3.4 * columns, 3.1 * rows + 0.7), facecolor="white")
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for axes in grid.flat[len(protocols) :]:
        axes.set_axis_off()
    limits = _around([ms_of[name] for name in backbones])
    for axes, protocol in zip(grid.flat, protocols, strict=False):
        for score in (s for s in found if s.protocol == protocol):
            colour = _COLOURS[backbones.index(score.backbone) % len(_COLOURS)]
            mark = _MARKS[methods.index(score.method) % len(_MARKS)]
            at = ms_of[score.backbone] + (score.predict_us or 0.0) / 1e3
            error, low, high = _errors(score)
            axes.plot([at, at], [low, high], color=colour, linewidth=1, alpha=0.6)
            axes.plot([at], [error], mark, color=colour, markersize=6, markeredgecolor="white", markeredgewidth=0.6)
        task, variant, split, modality = protocol
        axes.set_title(f"{task}, {variant}\n{split}, {modality}", fontsize=8.5)
        axes.set(xscale="log", yscale="log", xlim=limits, ylim=(_LEAST_ERROR * 0.8, 130))
        axes.grid(alpha=0.3, linewidth=0.5)
        for axis, ticks in ((axes.xaxis, _MS), (axes.yaxis, (0.1, 1, 10, 100))):
            axis.set_major_locator(FixedLocator(ticks))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_locator(NullLocator())
    for axes in grid.flat[max(0, len(protocols) - columns) : len(protocols)]:
        axes.set_xlabel("CPU ms a frame, one thread")
        axes.tick_params(labelbottom=True)
    for axes in grid[:, 0]:
        axes.set_ylabel(f"error, % ({_LEAST_ERROR:g}: that or less)")
    _legend(figure, backbones, methods)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.45 / figure.get_figheight()))
    figure.savefig(path, dpi=130)
    return path


def _around(ms: Sequence[float]) -> tuple[float, float]:
    """Limits of the axis of time: the labelled values around all of `ms`, with some air."""
    low = max((tick for tick in _MS if tick <= min(ms)), default=min(ms))
    high = min((tick for tick in _MS if tick >= max(ms)), default=max(ms))
    return low * 0.85, high * 1.15


def _errors(score: Score) -> tuple[float, float, float]:
    """Error and its interval in percent, no lower than the axis."""
    high = score.value if score.high is None else score.high
    low = score.value if score.low is None else score.low
    error, best, worst = (max(_LEAST_ERROR, 100 * (1 - value)) for value in (score.value, high, low))
    return error, best, worst


def _legend(figure: object, backbones: Sequence[str], methods: Sequence[str]) -> None:
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    assert isinstance(figure, Figure)
    handles = [
        *(Line2D([], [], color=_COLOURS[i % len(_COLOURS)], linewidth=4, label=n) for i, n in enumerate(backbones)),
        *(
            Line2D([], [], color="0.4", marker=_MARKS[i % len(_MARKS)], linestyle="", label=n)
            for i, n in enumerate(methods)
        ),
    ]
    figure.legend(handles=handles, loc="upper center", ncols=len(handles), frameon=False, fontsize=9)
