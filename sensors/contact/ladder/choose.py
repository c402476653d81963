"""Which rung a scene needs: the cheapest whose measured error is below its bound.

The error of a rung is its distance from the reference plus what the reference itself still moved in its last
refinement: no rung is called better than what it was measured against.
"""

from __future__ import annotations

from dataclasses import dataclass

from sensors.contact.ladder.indenters import areas_below, indenter, is_representative
from sensors.contact.ladder.interface import Pad
from sensors.contact.ladder.rungs import RUNGS
from sensors.contact.ladder.table import LadderTable, Row, committed_table
from sensors.contact.neohookean.surface import Surface

_ROUNDING = 1e-6
"""How far, relative, a pad may lie from a measured one and still be it."""

_ALIKE = 1.25
"""Factor by which the areas of a surface may differ from the representative's at the measured depths."""

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

    Errors are those of the class's representative (its size is in `INDENTER_CLASSES`) up to `depth_ratio` (d/h; all
    measured depths where None). The modulus of a pad does not matter; its Poisson's ratio must lie within those
    measured, its side over thickness between 6 and the widest measured; between measured pads the worse one counts.
    `surface` is what will press: its area below each depth must be the representative's up to a factor of 1.25. Springs
    fitted to the representative are offered for no other surface, and a rung that replays it only where `surface` is
    that representative on the pad's axis. Raises ValueError where nothing was measured for the pad, the class, the
    surface or the depth, or no rung is within the bounds; the message names the best there is.
    """
    table = committed_table() if table is None else table
    if not (bound_force > 0 and bound_displacement > 0):
        raise ValueError(f"error bounds must be positive, got force {bound_force}, displacement {bound_displacement}")
    depths = _depths(table, depth_ratio)
    choices: dict[str, Choice] = {}
    for rows in _neighbours(table, pad, indenter_class):
        moved = _reference_change(table, rows[0])
        for row in rows:
            one = _judge(row, moved, depths)
            choices[row.rung] = _worse(choices.get(row.rung, one), one)
    representative = surface is not None and is_representative(surface, indenter_class, pad)
    if surface is not None and not representative:
        _refuse_unlike(surface, indenter_class, pad, table.depth_ratios[:depths])
    offered = [one for name, one in choices.items() if representative or _serves(name, surface is None)]
    return _cheapest(offered, indenter_class, bound_force, bound_displacement)


def _cheapest(choices: list[Choice], indenter_class: str, bound_force: float, bound_displacement: float) -> Choice:
    within = [one for one in choices if one.force_error <= bound_force and one.displacement_error <= bound_displacement]
    if within:
        return min(within, key=lambda one: one.cost_ms)
    best = min(choices, key=lambda one: max(one.force_error / bound_force, one.displacement_error / bound_displacement))
    raise ValueError(
        f"no contact rung is within {bound_force:.3g} of the force and {bound_displacement:.3g} of the displacement "
        f"for the class {indenter_class}; the nearest is {best.rung} with {best.force_error:.3g} and "
        f"{best.displacement_error:.3g}: widen the bounds or press less deep"
    )


def _depths(table: LadderTable, depth_ratio: float | None) -> int:
    """How many of the table's depths count: up to the first that is at least `depth_ratio`."""
    if depth_ratio is None:
        return len(table.depth_ratios)
    if not depth_ratio > 0:
        raise ValueError(f"depth_ratio must be positive, got {depth_ratio}")
    for count, measured in enumerate(table.depth_ratios, 1):
        if measured >= depth_ratio:
            return count
    raise ValueError(f"depth_ratio {depth_ratio} is beyond the deepest measured, {table.depth_ratios[-1]}")


def _neighbours(table: LadderTable, pad: Pad, indenter_class: str) -> list[list[Row]]:
    """Rows of the class for each measured pad beside this one: Poisson's ratios and sides that enclose its own."""
    classes = sorted({row.indenter for row in table.rows})
    if indenter_class not in classes:
        raise ValueError(f"unknown indenter class {indenter_class!r}; measured: {', '.join(classes)}")
    rows = [row for row in table.rows if row.indenter == indenter_class]
    wanted, ratios = pad.material.poisson_ratio, sorted({row.poisson_ratio for row in rows})
    if not ratios[0] - _ROUNDING <= wanted <= ratios[-1] + _ROUNDING:
        raise ValueError(
            f"the contact ladder was measured for a poisson_ratio of {ratios[0]} to {ratios[-1]}, got {wanted} "
            "(measure it with measure_ladder)"
        )
    sides = sorted({row.side_ratio for row in rows})
    if not _NARROWEST <= pad.side_ratio <= sides[-1] * (1 + _ROUNDING):
        raise ValueError(
            f"a pad's side over its thickness must lie in [{_NARROWEST:g}, {sides[-1]:g}] for the measured ladder, "
            f"got {pad.side_ratio:.3g} (measure it with measure_ladder)"
        )
    pads = [(nu, side) for nu in _beside(ratios, wanted) for side in _beside(sides, pad.side_ratio)]
    return [[row for row in rows if (row.poisson_ratio, row.side_ratio) == one] for one in pads]


def _beside(measured: list[float], wanted: float) -> list[float]:
    """The one measured value that is `wanted`, or those next to it on either side."""
    equal = [one for one in measured if abs(one - wanted) <= _ROUNDING * wanted]
    below, above = [one for one in measured if one < wanted], [one for one in measured if one > wanted]
    return equal or below[-1:] + above[:1]


def _serves(rung: str, class_alone: bool) -> bool:
    """Whether what was measured of a rung holds for the class as such, or for a surface like its representative."""
    known = RUNGS.get(rung)
    return known is None or not (known.replays or (known.fitted and not class_alone))


def _refuse_unlike(surface: Surface, indenter_class: str, pad: Pad, depth_ratios: tuple[float, ...]) -> None:
    thickness = pad.material.thickness_m
    depths = [ratio * thickness for ratio in depth_ratios]
    areas = (areas_below(one, depths, pad) for one in (surface, indenter(indenter_class, thickness)))
    for ratio, own, measured in zip(depth_ratios, *areas, strict=True):
        if not measured / _ALIKE <= own <= measured * _ALIKE:
            raise ValueError(
                f"the surface is not of the size measured as {indenter_class}: below d/h {ratio:g} it covers "
                f"{own / thickness**2:.3g} h^2, the measured one {measured / thickness**2:.3g} h^2, more than a factor "
                f"of {_ALIKE:g} apart (measure it with measure_ladder)"
            )


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


def _worse(one: Choice, other: Choice) -> Choice:
    return Choice(
        one.rung,
        max(one.force_error, other.force_error),
        max(one.displacement_error, other.displacement_error),
        max(one.cost_ms, other.cost_ms),
    )
