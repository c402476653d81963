"""Which rung a scene needs: the cheapest whose measured error is below its bound.

The error of a rung is its distance from the reference plus what the reference itself still moved in its last
refinement: no rung is called better than what it was measured against.
"""

from __future__ import annotations

from dataclasses import dataclass

from sensors.contact.ladder.indenters import is_representative
from sensors.contact.ladder.interface import Pad
from sensors.contact.ladder.rungs import RUNGS
from sensors.contact.ladder.table import LadderTable, Row, committed_table
from sensors.contact.neohookean.surface import Surface

_POISSON_REACH = 0.03
"""How far a pad's Poisson's ratio may lie from a measured one."""

_NARROWEST = 6.0
"""Side over thickness below which a pad's free sides are felt, which the flat rungs do not know."""


@dataclass(frozen=True)
class Choice:
    """The rung taken, with its largest relative errors (reference's own included) and its cost (ms CPU a step).

    Opening the rung is not counted: one that replays is trained then, by twenty presses of the full model.
    """

    rung: str
    force_error: float
    displacement_error: float
    cost_ms: float


def choose_rung(
    pad: Pad,
    indenter_class: str,
    bound_force: float,
    bound_displacement: float,
    *,
    depth_ratio: float | None = None,
    surface: Surface | None = None,
    table: LadderTable | None = None,
) -> Choice:
    """The cheapest rung whose measured errors are within both bounds (relative, 0.02 = 2 %).

    Errors count up to `depth_ratio` (d/h; all measured depths where None). The modulus of a pad does not matter; its
    Poisson's ratio must be within 0.03 of a measured one, and its side over thickness between 6 and the widest
    measured. A rung that replays its class's representative alone is offered where `surface`, what will press, is that
    representative on the pad's axis; not for the class as such, nor for a contact that has moved. Raises ValueError
    where nothing was measured for the pad, the class or the depth, or no rung is within the bounds; the message names
    the best there is.
    """
    table = committed_table() if table is None else table
    if not (bound_force > 0 and bound_displacement > 0):
        raise ValueError(f"error bounds must be positive, got force {bound_force}, displacement {bound_displacement}")
    depths = _depths(table, depth_ratio)
    rows = _rows(table, pad, indenter_class)
    if surface is None or not is_representative(surface, indenter_class, pad):
        rows = [row for row in rows if not (row.rung in RUNGS and RUNGS[row.rung].replays)]
    moved = _reference_change(table, rows[0])
    choices = [_judge(row, moved, depths) for row in rows]
    within = [one for one in choices if one.force_error <= bound_force and one.displacement_error <= bound_displacement]
    if within:
        return min(within, key=lambda one: one.cost_ms)
    best = min(choices, key=lambda one: max(one.force_error / bound_force, one.displacement_error / bound_displacement))
    raise ValueError(
        f"no contact rung is within {bound_force:.2%} of the force and {bound_displacement:.2%} of the displacement "
        f"for the class {indenter_class}; the nearest is {best.rung} with {best.force_error:.2%} and "
        f"{best.displacement_error:.2%}: widen the bounds or press less deep"
    )


def _depths(table: LadderTable, depth_ratio: float | None) -> int:
    """How many of the table's depths count: up to the first that is at least `depth_ratio`."""
    if depth_ratio is None:
        return len(table.depth_ratios)
    for count, measured in enumerate(table.depth_ratios, 1):
        if measured >= depth_ratio:
            return count
    raise ValueError(f"depth_ratio {depth_ratio} is beyond the deepest measured, {table.depth_ratios[-1]}")


def _rows(table: LadderTable, pad: Pad, indenter_class: str) -> list[Row]:
    """Rows of the nearest Poisson's ratio and of the next wider pad (the flat rungs' cells are coarser there)."""
    classes = sorted({row.indenter for row in table.rows})
    if indenter_class not in classes:
        raise ValueError(f"unknown indenter class {indenter_class!r}; measured: {', '.join(classes)}")
    rows = [row for row in table.rows if row.indenter == indenter_class]
    wanted = pad.material.poisson_ratio
    poisson = min({row.poisson_ratio for row in rows}, key=lambda nu: abs(nu - wanted))
    if abs(poisson - wanted) > _POISSON_REACH:
        raise ValueError(
            f"the contact ladder was not measured near poisson_ratio {wanted}; the nearest is {poisson} (measure it "
            "with measure_ladder)"
        )
    rows = [row for row in rows if row.poisson_ratio == poisson]
    widest = max(row.side_ratio for row in rows)
    if not _NARROWEST <= pad.side_ratio <= widest * (1 + 1e-9):
        raise ValueError(
            f"a pad's side over its thickness must lie in [{_NARROWEST:g}, {widest:g}] for the measured ladder, "
            f"got {pad.side_ratio:.3g} (measure it with measure_ladder)"
        )
    side = min(row.side_ratio for row in rows if row.side_ratio * (1 + 1e-9) >= pad.side_ratio)
    return [row for row in rows if row.side_ratio == side]


def _reference_change(table: LadderTable, row: Row) -> Row:
    for change in table.reference_change:
        if (change.poisson_ratio, change.indenter) == (row.poisson_ratio, row.indenter):
            return change
    raise ValueError(
        f"the ladder table lacks the reference's change for poisson_ratio {row.poisson_ratio}, {row.indenter}; "
        "write it anew with `python -m sensors.contact.ladder`"
    )


def _judge(row: Row, moved: Row, depths: int) -> Choice:
    forces = [abs(a) + abs(b) for a, b in zip(row.force_error, moved.force_error, strict=True)]
    shapes = [a + b for a, b in zip(row.displacement_error, moved.displacement_error, strict=True)]
    return Choice(row.rung, max(forces[:depths]), max(shapes[:depths]), row.cost_ms)
