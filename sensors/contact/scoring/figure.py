"""Error against speed: the ladder against the hyperelastic pad, the models against closed forms, and the peer."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from sensors.contact.scoring.closed_forms import OracleRow
from sensors.contact.scoring.hyperelastic import SolidRow
from sensors.contact.scoring.peer import PeerRow

_COLOURS = ("#b3462f", "#2b6a8f", "#3f8f5f", "#8a6bb0", "#a98a2e", "#555555", "#d17aa5")
_MARKS = "osD^vPX"
_LEAST = 1e-4
"""Percent; errors below it stand on this line of the logarithmic axis."""


def draw_physics(
    path: Path, solid: Sequence[SolidRow], oracles: Sequence[OracleRow], peers: Sequence[PeerRow], deepest: int
) -> Path:
    """Draw the panels into `path` and return it; `deepest` is how many of the ladder's depths count."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14.5, 5.2), facecolor="white")
    FigureCanvasAgg(figure)
    left, middle, right = figure.subplots(1, 3)
    rungs, classes = (list(dict.fromkeys(getattr(row, name) for row in solid)) for name in ("rung", "indenter"))
    for row in solid:
        left.plot(
            [row.cost_ms],
            [100 * max(map(abs, row.force[:deepest]))],
            _MARKS[classes.index(row.indenter)],
            color=_COLOURS[rungs.index(row.rung)],
            label=row.rung if row.indenter == classes[0] else None,
            markersize=7,
        )
    for number, name in enumerate(classes):
        left.plot([], [], _MARKS[number], color="none", markeredgecolor="black", label=name)
    moved = 100 * max(max(row.reference[:deepest]) for row in solid)
    left.axhspan(0, moved, color="#999999", alpha=0.25, linewidth=0, label="reference's own change")
    left.set(yscale="log", ylim=(0.1, 30), ylabel="force error, %", title="against the hyperelastic pad, d/h to 0.2")
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
        ylim=(2e-8, 30),
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
        axes.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=130, format="png")
    return path
