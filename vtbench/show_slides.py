"""Pictures of slides: force traces with what the contact did, and the scores of detectors against their thresholds."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vtbench.data.slide_reader import SlideDataset
from vtbench.show import INK, QUIET, heading, page

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

STATE_COLOURS = {1: "#f6d58a", 2: "#f2b5a7"}
_SHADES = {1: "yellow: partial slip", 2: "red: gross slip"}
_ONSET = "dashed: onset"
SHADES = ", ".join([*_SHADES.values(), _ONSET])
DETECTORS = {"covariance": "covariance [N²]", "energy": "energy [N]"}
THRESHOLD = "#a63d6d"
PERIODS = 3
"""Consecutive samples at or above beta that raise an alarm, as in the tasks."""
_NAMED_TAXELS = 6


def slide_sheet(dataset_dir: Path | str, png: Path | str) -> Path:
    """Draw one trial of each kind and object: all taxels, the state of the contact shaded, the onset marked."""
    dataset = SlideDataset.open(dataset_dir)
    rows = dataset.columns()
    kinds, objects = list(dict.fromkeys(rows["kind"])), list(dict.fromkeys(rows["object"]))
    chosen = [_first(rows, kind, name) for kind in kinds for name in objects]
    series, states = _by_trial(dataset, chosen)
    with page(png, (3.9 * len(objects) + 0.5, 1.75 * len(kinds) + 1.3)) as figure:
        heading(figure, dataset.meta.name, _summary(dataset))
        body = figure.subfigures(2, 1, squeeze=False, height_ratios=[0.85, 1.75 * len(kinds) + 0.45])[1, 0]
        edges = {"left": 0.055, "right": 0.985, "bottom": 0.5 / (1.75 * len(kinds) + 0.45), "top": 0.96}
        places = body.subplots(len(kinds), len(objects), squeeze=False, gridspec_kw={**edges, "hspace": 0.45})
        for axes, trial in zip(places.ravel(), chosen, strict=True):
            if trial is None:
                axes.axis("off")
                continue
            row = rows.iloc[trial]
            _forces(axes, series[trial], states[trial], row, named=0)
            axes.set_title(_title(row), loc="left", fontsize=8.5, color=INK, fontweight="bold", pad=3)
            axes.set_title(_condition(row), loc="right", fontsize=7.5, color=QUIET, pad=3)
        for axes in places[-1]:
            axes.set_xlabel("time [s]")
        for axes in places[:, 0]:
            axes.set_ylabel("force [N]")
    return Path(png)


def slide_scores(dataset_dir: Path | str, trial: int, png: Path | str) -> Path:
    """Draw one trial: forces, and below them each detector's score against the beta of an earlier slip.

    The earlier slip is the first other trial of the dataset that slips; without one no beta is drawn.
    Raises ValueError for a trial that does not exist.
    """
    import slip

    dataset = SlideDataset.open(dataset_dir)
    if trial >= dataset.n:
        raise ValueError(f"{dataset.path}: no sample {trial}, there are {dataset.n}, counted from 0")
    rows, onsets = dataset.columns(), dataset.onsets()
    earlier = next((at for at, onset in enumerate(onsets) if onset is not None and at != trial), None)
    wanted = [trial] if earlier is None else [trial, earlier]
    series, states = _by_trial(dataset, wanted)
    row = rows.iloc[trial]
    time_s = np.arange(len(series[trial])) / row["rate_hz"]
    with page(png, (10.5, 3.6 + 1.9 * len(DETECTORS))) as figure:
        where = f"{dataset.meta.name}, sample {trial}: {_condition(row)}, unit {row['unit']}"
        bars = f"bar: alarm, {PERIODS} samples at or above β" if earlier is not None else "no β: no other sample slips"
        heading(figure, _title(row), "; ".join([where, *_drawn_shades(states[trial], row), bars]))
        body = figure.subfigures(2, 1, squeeze=False, height_ratios=[0.85, 2.75 + 1.9 * len(DETECTORS)])[1, 0]
        ratios = [2.2, *[1.3] * len(DETECTORS)]
        edges = {"left": 0.085, "right": 0.98, "bottom": 0.08, "top": 0.98, "hspace": 0.12, "height_ratios": ratios}
        places = body.subplots(1 + len(DETECTORS), 1, sharex=True, gridspec_kw=edges)
        _forces(places[0], series[trial], states[trial], row, named=_NAMED_TAXELS)
        places[0].set_ylabel("force [N]")
        for axes, (name, label) in zip(places[1:], DETECTORS.items(), strict=True):
            _shade(axes, states[trial], row)
            score = slip.make_detector(name).score(series[trial])
            axes.plot(time_s, score, color=INK, lw=1.0)
            top = float(score.max())
            if earlier is not None:
                gross = np.flatnonzero(states[earlier] == 2)
                beta = slip.prior(slip.make_detector(name), series[earlier], (gross[0], gross[-1] + 1)).beta
                top = max(top, beta)
                _threshold(axes, time_s, score, beta, f"β from the slip of sample {earlier}")
            axes.set(ylabel=label, ylim=(-0.09 * top, 1.08 * top or 1.0))
        body.align_ylabels(places)
        places[-1].set_xlabel("time [s]")
        places[-1].set_xlim(0, time_s[-1] + 1 / row["rate_hz"])
    return Path(png)


def _threshold(axes: Axes, time_s: NDArray[np.float64], score: NDArray[np.float64], beta: float, text: str) -> None:
    """A line at beta, named at its left end, and a bar below zero while the alarm is on."""
    import slip

    axes.axhline(beta, color=THRESHOLD, lw=1.0, ls=(0, (4, 2)))
    axes.annotate(
        text,
        (0.0, beta),
        xytext=(5, 8),
        textcoords="offset points",
        color=THRESHOLD,
        fontsize=8,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8},
    )
    edges = np.flatnonzero(np.diff(slip.hold_on(score >= beta, PERIODS).astype(np.int8), prepend=0, append=0))
    step = float(time_s[1]) if len(time_s) > 1 else 0.0
    for first, last in edges.reshape(-1, 2):
        span = (time_s[first], time_s[last - 1] + step)
        axes.hlines(0.04, *span, color=THRESHOLD, lw=4, transform=axes.get_xaxis_transform())


def _forces(axes: Axes, series: NDArray[np.float32], state: NDArray[np.uint8], row: Any, named: int) -> None:
    """Taxel traces over the shaded state; the `named` strongest in colour."""
    time_s = np.arange(len(series)) / row["rate_hz"]
    _shade(axes, state, row)
    order = np.argsort(series.max(axis=0))[::-1]
    for rank, taxel in enumerate(order):
        colour = f"C{rank}" if rank < max(named, 4) else "#c5ccd4"
        label = f"taxel {taxel + 1}" if rank < named else "the other taxels" if named and rank == named else None
        axes.plot(time_s, series[:, taxel], color=colour, lw=0.9, label=label, zorder=2 - rank / 100)
    axes.set_xlim(0, time_s[-1])
    if named:
        axes.legend(frameon=False, loc="upper left", fontsize=8, ncols=2, labelcolor=INK)


def _shade(axes: Axes, state: NDArray[np.uint8], row: Any) -> None:
    """Spans of partial and gross slip, and a line at the onset."""
    edges = np.flatnonzero(np.diff(state, prepend=0, append=0))
    for first, last in pairwise(edges):
        if state[first] in STATE_COLOURS:
            colour = STATE_COLOURS[int(state[first])]
            axes.axvspan(first / row["rate_hz"], last / row["rate_hz"], color=colour, alpha=0.55, lw=0, zorder=0)
    if row["onset"] == row["onset"]:
        axes.axvline(row["onset"] / row["rate_hz"], color=INK, lw=0.8, ls=(0, (2, 2)))


def _drawn_shades(state: NDArray[np.uint8], row: Any) -> list[str]:
    """What `_shade` draws of this trial, in words."""
    shades = [name for value, name in _SHADES.items() if (state == value).any()]
    shades += [_ONSET] if row["onset"] == row["onset"] else []
    return [", ".join(shades)] if shades else []


def _by_trial(
    dataset: SlideDataset, trials: list[Any]
) -> tuple[dict[int, NDArray[np.float32]], dict[int, NDArray[np.uint8]]]:
    wanted = [trial for trial in trials if trial is not None]
    series, states = dataset.force_series(wanted), dataset.states(wanted)
    return dict(zip(wanted, series, strict=True)), dict(zip(wanted, states, strict=True))


def _first(rows: pd.DataFrame, kind: str, name: str) -> int | None:
    mine = rows.index[(rows["kind"] == kind) & (rows["object"] == name)]
    return int(mine[len(mine) // 2]) if len(mine) else None


def _title(row: Any) -> str:
    return f"{row['object']}, {str(row['kind']).replace('_', ' ')}"


def _condition(row: Any) -> str:
    parts = [f"{row['load_n']:g} N"]
    parts += [f"{row['speed_mm_s']:g} mm/s, {row['direction_deg']:g}°"] if row["speed_mm_s"] else []
    parts += [f"{row['rotation_deg_s']:g} °/s"] if row["rotation_deg_s"] else []
    return ", ".join(parts).replace("-", "\N{MINUS SIGN}")


def _summary(dataset: SlideDataset) -> str:
    found = dataset.summary()
    return (
        f"{found['samples']} trials, {found['with_slip']} with slip, {found['minutes']:g} min at "
        f"{found['rate_hz']:g} Hz; one trial of each kind, four taxels in colour; {SHADES}; dataset {dataset.hash[:12]}"
    )
