"""The cheapest contact model and grid whose measured errors are within a scene's bounds.

A film on a plate has two models, the elastic layer and springs in its place; a hollow skin has one. An error is the
distance from the reference plus what the reference itself still moves on a finer grid; a film on a plate is linear in
the reference, too, so that a bound counts on top what finite strain changes at the depth that it is pressed to.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from sensors.grids.table import GridRow, GridTable, committed_grids

if TYPE_CHECKING:
    from sensors.contact.ladder.finite_strain import LinearError

BOUNDS = {"force": "of the force", "displacement": "of the displacement", "frame": "grey levels"}
"""What can be bounded: the first two relative (0.02 = 2 %), the frame in grey levels."""

_ALIKE = 0.1
"""How far, relative, a pad's parameters may lie from those measured."""

_LOADS = 1.3
"""How far, as a factor, loads may lie outside those measured."""


@dataclass(frozen=True)
class GridChoice:
    """Grid and model taken, with their largest measured errors (the reference's own included) and cost (CPU ms).

    `depth_ratio` is the deepest measured indentation of a film on a plate over its thickness; `linear`, where a bound
    took the choice, what is counted in the errors for that film's linear model.
    """

    grid: int
    force: float
    displacement: float
    frame: float
    cost_ms: float
    contact: str = "elastic"
    depth_ratio: float = 0.0
    linear: LinearError | None = None

    @property
    def taken(self) -> dict[str, Any]:
        """The sensor's parameters that say so."""
        return {"grid": self.grid, "contact": self.contact}


def choose_grid(
    sensor: Mapping[str, Any],
    classes: Iterable[str],
    loads_n: Iterable[float],
    bounds: Mapping[str, float],
    table: GridTable | None = None,
) -> GridChoice:
    """The cheapest model and grid that are within all `bounds` (see `BOUNDS`) for every class of object.

    `sensor` holds the parameters that name a pad. On a plate the errors count what a linear film leaves out. Raises
    ValueError where nothing was measured for the pad, a class or the loads, or no grid is within the bounds; the
    message names the best there is.
    """
    table, loads = committed_grids() if table is None else table, tuple(loads_n)
    choices = measured_choices(sensor, classes, loads, table)
    if sensor["support"] == "plate":
        choices = _with_linear_errors(choices, bounds, max(loads) / max(table.loads_n), sensor["film_poisson"])
    within = [one for one in choices if all(getattr(one, name) <= bound for name, bound in bounds.items())]
    if within:
        return min(within, key=lambda one: one.cost_ms)
    best = min(choices, key=lambda one: max(getattr(one, name) / bound for name, bound in bounds.items()))
    words = ", ".join(f"{name} {getattr(best, name):.3g} (bound {bound:g})" for name, bound in bounds.items())
    name = f"{best.grid}x{best.grid}" + (" of springs" if best.contact == "springs" else "")
    if best.linear is not None:
        words += f", {best.linear.force:.3g} of the force by finite strain of the film at d/h {best.depth_ratio:.2f}"
    raise ValueError(f"no contact grid is within the error bound; the nearest is {name} with {words}")


def refuse_deeper(choice: GridChoice, depth_ratio: float, poisson_ratio: float, bounds: Mapping[str, float]) -> None:
    """ValueError where a press came deeper than a choice counted with, and breaks a bound by that."""
    from sensors.contact.ladder.finite_strain import linear_error

    if choice.linear is None or depth_ratio <= choice.linear.depth_ratio:
        return
    actual = linear_error(depth_ratio, poisson_ratio)
    for name, bound in bounds.items():
        off = getattr(choice, name) - getattr(choice.linear, name) + getattr(actual, name)
        if off > bound:
            raise ValueError(
                f"the film is pressed to {depth_ratio:.2f} of its thickness, where its linear model may be off by "
                f"{getattr(actual, name):.3g} of the {name}, {off:.3g} with the grid (error bound {bound:g}): lower "
                "the load or widen the bound"
            )


def _with_linear_errors(
    choices: list[GridChoice], bounds: Mapping[str, float], heavier: float, poisson_ratio: float
) -> list[GridChoice]:
    """The choices with what finite strain adds; loads heavier than measured count as that much deeper."""
    from sensors.contact.ladder.finite_strain import linear_error

    if "frame" in bounds:
        raise ValueError(
            "an error bound on the frame cannot be kept on a plate: what a linear film leaves out is not measured in "
            "grey levels; bound force or displacement"
        )
    kept, refused = [], ValueError("nothing measured")
    for one in choices:
        depth = one.depth_ratio * max(1.0, heavier)
        try:
            linear = linear_error(depth, poisson_ratio)
        except ValueError as error:
            refused = error
            continue
        force, displacement = one.force + linear.force, one.displacement + linear.displacement
        kept.append(replace(one, force=force, displacement=displacement, depth_ratio=depth, linear=linear))
    if not kept:
        raise ValueError(f"no contact model is within the error bound: {refused}; lower the load") from refused
    return kept


def measured_choices(
    sensor: Mapping[str, Any], classes: Iterable[str], loads_n: Iterable[float], table: GridTable | None = None
) -> list[GridChoice]:
    """Every measured model and grid for a pad, the worst of `classes` each; see `choose_grid`."""
    table = committed_grids() if table is None else table
    pad = _pad(table, sensor)
    low, high = min(table.loads_n) / _LOADS, max(table.loads_n) * _LOADS
    outside = [load for load in loads_n if not low <= load <= high]
    if outside:
        raise ValueError(f"contact grids were measured for loads of {low:.2g} to {high:.2g} N, got {outside[0]:g} N")
    asked = set(classes)
    known = {row.objects for row in table.rows if row.pad == pad}
    if asked - known:
        raise ValueError(f"contact grids were not measured with objects of the class {min(asked - known)!r}")
    grids = sorted({(row.grid, row.contact) for row in table.rows if row.pad == pad})
    return [_worst(table, pad, asked, grid, contact) for grid, contact in grids]


def _worst(table: GridTable, pad: str, classes: set[str], grid: int, contact: str) -> GridChoice:
    def picked(rows: tuple[GridRow, ...]) -> dict[str, GridRow]:
        return {row.objects: row for row in rows if row.pad == pad and row.objects in classes}

    moved = picked(table.reference_change)
    rows = picked(tuple(row for row in table.rows if (row.grid, row.contact) == (grid, contact)))
    if set(rows) != classes or set(moved) != classes:
        raise ValueError(
            f"the table of contact grids lacks rows of {pad}: write it anew with `python -m sensors.grids`"
        )
    force, displacement, frame = (
        max(getattr(row, name) + getattr(moved[objects], name) for objects, row in rows.items()) for name in BOUNDS
    )
    cost_ms, deepest = (max(getattr(row, name) for row in rows.values()) for name in ("cost_ms", "depth_ratio"))
    return GridChoice(grid, force, displacement, frame, cost_ms, contact, deepest)


def _pad(table: GridTable, sensor: Mapping[str, Any]) -> str:
    for name, pad in table.pads.items():
        if all(_alike(sensor[key], value) for key, value in pad.items()):
            return name
    known = "; ".join(f"{name} ({', '.join(f'{k} {v}' for k, v in pad.items())})" for name, pad in table.pads.items())
    raise ValueError(
        f"contact grids were not measured for this sensor's pad: set sensor.grid itself; measured: {known}"
    )


def _alike(value: Any, measured: Any) -> bool:
    return value == measured if isinstance(measured, str) else math.isclose(value, measured, rel_tol=_ALIKE)
