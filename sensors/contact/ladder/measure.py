"""Measures every rung against a mesh-converged hyperelastic pad: errors over indenters and depths, and cost."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from sensors.contact.grid import Grid
from sensors.contact.ladder.indenters import INDENTER_CLASSES, indenter
from sensors.contact.ladder.interface import Pad, Response, Rung
from sensors.contact.ladder.rungs import RUNGS
from sensors.contact.ladder.solid import NeoHookeanRung
from sensors.contact.ladder.table import LadderTable, Row
from sensors.contact.layer import LayerMaterial
from sensors.contact.solver import ConvergenceError

Floats = NDArray[np.floating]

POISSON_RATIOS = (0.41, 0.45)
SIDE_RATIOS = (8.0, 16.0)
DEPTH_RATIOS = (0.05, 0.1, 0.2, 0.3)
REFERENCE = NeoHookeanRung("reference", 24, 10)
COARSER = NeoHookeanRung("neohookean", 16, 7)
"""The mesh whose distance from the reference says how far that has converged (1.5 times larger cells)."""

_REFERENCE_SIDE = 8.0
_CHEAP_MS = 200.0
"""Paths cheaper than this a step are timed five times and the median kept."""


def measure_ladder(
    poisson_ratios: Sequence[float] = POISSON_RATIOS,
    side_ratios: Sequence[float] = SIDE_RATIOS,
    indenters: Sequence[str] = tuple(INDENTER_CLASSES),
    depth_ratios: Sequence[float] = DEPTH_RATIOS,
    *,
    rungs: Sequence[Rung] = tuple(RUNGS.values()),
    reference: NeoHookeanRung = REFERENCE,
    coarser: NeoHookeanRung = COARSER,
    report: Callable[[str], None] = lambda line: None,
) -> LadderTable:
    """Errors and costs of `rungs` over pads, classes of indenter and depths d/h.

    The thickness and the modulus are one: neither changes a relative error. The reference is pressed once per Poisson's
    ratio and class, on a pad of side 8; wider pads are compared over that part. `report` gets a line per row; a rung
    that does not converge gets a line and no row. About twenty minutes of one core for the defaults. Raises
    ConvergenceError where the reference does not converge.
    """
    changes, rows = [], []
    for nu in poisson_ratios:
        for name in indenters:
            pad = _pad(nu, _REFERENCE_SIDE)
            exact, _ = _path(reference, pad, name, depth_ratios)
            coarse = _path(coarser, pad, name, depth_ratios)
            changes.append(_row(pad, name, "reference change", coarse[0], exact, coarse[1]))
            report(format_row(changes[-1]))
            for side in side_ratios:
                for rung in rungs:
                    pad = _pad(nu, side)
                    try:
                        known = rung == coarser and side == _REFERENCE_SIDE
                        path, cost = coarse if known else _path(rung, pad, name, depth_ratios)
                    except ConvergenceError as error:
                        report(f"nu {nu:g} L/h {side:g} {name} {rung.name}: left out, {error}")
                        continue
                    rows.append(_row(pad, name, rung.name, path, exact, cost))
                    report(format_row(rows[-1]))
    words = f"neohookean, {reference.cells} cells from centre to side, {reference.layers} layers, graded"
    return LadderTable(tuple(depth_ratios), words, _machine(), tuple(changes), tuple(rows))


def format_row(row: Row) -> str:
    """One line: pad, indenter, rung, signed force errors and displacement errors in %, cost."""
    forces = " ".join(f"{100 * error:+7.2f}" for error in row.force_error)
    shapes = " ".join(f"{100 * error:6.2f}" for error in row.displacement_error)
    pad = f"nu {row.poisson_ratio:<5g} L/h {row.side_ratio:<3g}"
    return f"{pad} {row.indenter:<11}{row.rung:<17} force % {forces} | displacement % {shapes} | {row.cost_ms:9.2f} ms"


def _pad(poisson_ratio: float, side: float) -> Pad:
    return Pad(LayerMaterial(1.0, 1.0, poisson_ratio), side)


def _path(rung: Rung, pad: Pad, name: str, depths: Sequence[float]) -> tuple[list[Response], float]:
    """Responses along the path, and the CPU of a step in ms (opening the rung left out)."""
    opened = rung.open(pad, name)
    surface = indenter(name, pad.material.thickness_m)

    def run() -> Iterator[Response]:
        return opened.press_depths(surface, [ratio * pad.material.thickness_m for ratio in depths])

    costs: list[float] = []
    while len(costs) < 5:
        start = time.process_time()
        path = list(run())
        costs.append(1e3 * (time.process_time() - start) / len(path))
        if costs[0] > _CHEAP_MS:
            break
    return path, float(np.median(costs))


def _row(pad: Pad, name: str, rung: str, path: Sequence[Response], exact: Sequence[Response], cost_ms: float) -> Row:
    forces = [one.force_n / other.force_n - 1 for one, other in zip(path, exact, strict=True)]
    shapes = [displacement_error(one, other) for one, other in zip(path, exact, strict=True)]
    return Row(
        pad.material.poisson_ratio,
        pad.side_ratio,
        name,
        rung,
        tuple(round(float(error), 5) for error in forces),
        tuple(round(error, 5) for error in shapes),
        round(cost_ms, 3),
    )


def displacement_error(response: Response, reference: Response) -> float:
    """Root mean square difference of the displacements over the reference's own, on the reference's grid."""
    there = sample(response.displacement, response.grid, *reference.grid.coordinates())
    difference = np.sqrt(np.mean((there - reference.displacement) ** 2))
    return float(difference / np.sqrt(np.mean(reference.displacement**2)))


def sample(field: Floats, grid: Grid, x: Floats, y: Floats) -> Floats:
    """Bilinear values of an (n, n) field at points (m), the outermost cells going on."""
    place = [(axis + grid.size_m / 2) / grid.pitch_m - 0.5 for axis in (y, x)]
    out: Floats = map_coordinates(np.asarray(field, np.float64), place, order=1, mode="nearest")
    return out


def _machine() -> str:
    return f"{platform.machine()}, one thread, Python {platform.python_version()}, NumPy {np.__version__}"
