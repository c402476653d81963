"""Error against speed: the ladder against the hyperelastic pad, the models against closed forms, and the peer."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sensors.contact.scoring.closed_forms import OracleRow
from sensors.contact.scoring.hyperelastic import SolidRow
from sensors.contact.scoring.peer import PeerRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS = ("#b3462f", "#2b6a8f", "#3f8f5f", "#8a6bb0", "#a98a2e", "#555555", "#d17aa5")
_MARKS = "osD^vPX"
_LEAST = 1e-4
"""Percent; errors against closed forms below it stand on this line of the logarithmic axis."""


def draw_physics(
    path: Path, solid: Sequence[SolidRow], oracles: Sequence[OracleRow], peers: Sequence[PeerRow], deepest: int
) -> Path:
    """Draw the panels into `path` and return it; `deepest` is how many of the ladder's depths count."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14.5, 6.4), facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    left, middle, right = figure.subplots(1, 3)
    _draw_ladder(left, solid, deepest)
    timed = [row for row in oracles if row.warm_ms is not None]
    kinds = list(dict.fromkeys((row.model, row.oracle) for row in timed))
    for number, kind in enumerate(kinds):
        for precision, face in (("float32", "none"), ("float64", None)):
            rows = [row for row in timed if (row.model, row.oracle, row.precision) == (*kind, precision)]
            colour = _COLOURS[number % len(_COLOURS)]
            middle.plot(
                [row.warm_ms or 0.0 for row in rows],
                [max(100 * row.error, _LEAST) for row in rows],
                _MARKS[number % len(_MARKS)] + ("-" if precision == "float64" else ":"),
                color=colour,
                markerfacecolor=colour if face is None else face,
                label=": ".join(kind) if precision == "float64" else None,
                linewidth=0.8,
            )
    middle.set(
        yscale="log",
        ylabel="error, %",
        title="against closed forms, 64 to 256 cells\n(hollow: float32; warm)",
    )
    for name, error, cost, colour in (
        ("vtbench", [p.error for p in peers], [p.ours_ms for p in peers], _COLOURS[1]),
        ("tamaas", [p.peer_error for p in peers], [p.peer_ms for p in peers], _COLOURS[0]),
    ):
        right.plot(cost, [100 * value for value in error], "o-", color=colour, label=name)
    for peer in peers:
        right.annotate(
            f"{peer.grid}: {peer.ratio:.1f}x",
            (peer.ours_ms, 100 * peer.error),
            xytext=(4, 6),
            textcoords="offset points",
        )
    panels = [left, middle]
    if peers:
        errors = [100 * value for peer in peers for value in (peer.error, peer.peer_error)]
        right.set(yscale="log", ylim=(0.8 * min(errors), 1.25 * max(errors)), ylabel="error of the pressure field, %")
        right.set_title("half-space under a sphere, cold, float64")
        right.yaxis.set_major_formatter("{x:g}")
        right.yaxis.set_minor_formatter("{x:g}")
        panels.append(right)
    else:
        right.set_axis_off()
        right.text(0.5, 0.5, "the peer solver is not installed", ha="center", transform=right.transAxes)
    for axes in panels:
        axes.set_xlabel("CPU ms a solve, one thread")
        axes.set_xscale("log")
        axes.grid(alpha=0.3, linewidth=0.5)
        # below the panel, where no point can lie
        axes.legend(fontsize=7.5, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, frameon=False)
    figure.savefig(path, dpi=130, format="png")
    return path


def _draw_ladder(axes: Axes, solid: Sequence[SolidRow], deepest: int) -> None:
    """Each rung under each class; hollow where the error is less than the reference of that class itself still moved.

    Marks shrink from class to class, so that those of equal error and cost show inside one another.
    """
    rungs, classes = (list(dict.fromkeys(getattr(row, name) for row in solid)) for name in ("rung", "indenter"))
    moved = {row.indenter: max(row.reference[:deepest]) for row in solid}
    for row in solid:
        number, colour = classes.index(row.indenter), _COLOURS[rungs.index(row.rung)]
        error = max(map(abs, row.force[:deepest]))
        resolved = error > moved[row.indenter]
        axes.plot(
            [row.cost_ms],
            [100 * error],
            _MARKS[number],
            markeredgecolor="white" if resolved else colour,
            markerfacecolor=colour if resolved else "white",
            markersize=12 - 1.5 * number,
            zorder=2 + number,
        )
    for number, rung in enumerate(rungs):
        axes.plot([], [], "s", color=_COLOURS[number], label=rung)
    for number, name in enumerate(classes):
        label = f"{name} (reference moved {moved[name]:.1%})"
        axes.plot([], [], _MARKS[number], color="none", markeredgecolor="black", label=label)
    axes.plot([], [], "o", color="#555555", markerfacecolor="white", label="hollow: less than the reference moved")
    axes.set(yscale="log", ylabel="force error, %", title="against the hyperelastic pad, d/h to 0.2")
    axes.yaxis.set_major_formatter("{x:g}")
