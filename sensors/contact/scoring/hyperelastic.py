"""The rungs of the ladder against the hyperelastic pad, out of the committed table."""

from __future__ import annotations

from dataclasses import dataclass

from sensors.contact.ladder.table import LadderTable, Row, committed_table


@dataclass(frozen=True)
class SolidRow:
    """A rung under a class of indenter, worst over the measured pads.

    `force` signed and `displacement` (RMS) relative, one a depth of the table; `reference` what the force of the
    reference itself still moved in its last refinement; `cost_ms` CPU a step of a warm path, median over the pads.
    """

    rung: str
    indenter: str
    force: tuple[float, ...]
    displacement: tuple[float, ...]
    reference: tuple[float, ...]
    cost_ms: float


def against_hyperelastic(side_ratio: float | None = None, table: LadderTable | None = None) -> list[SolidRow]:
    """A row for each rung and class; pads of `side_ratio` (side over thickness) alone, all where None.

    ValueError where the table holds no such pad.
    """
    table = committed_table() if table is None else table
    rows = [row for row in table.rows if side_ratio is None or row.side_ratio == side_ratio]
    if not rows:
        known = sorted({row.side_ratio for row in table.rows})
        raise ValueError(f"the ladder was measured on pads of side over thickness {known}, not {side_ratio}")
    keys = dict.fromkeys((row.rung, row.indenter) for row in rows)
    return [_worst([row for row in rows if (row.rung, row.indenter) == key], table.reference_change) for key in keys]


def force_within(
    bound: float, depth_ratio: float, rung: str, table: LadderTable | None = None
) -> tuple[float, list[str]]:
    """Largest force error of a rung up to a depth d/h, and the classes of indenter that stay within `bound`."""
    table = committed_table() if table is None else table
    count = sum(depth <= depth_ratio + 1e-9 for depth in table.depth_ratios)
    worst = {
        row.indenter: max(map(abs, row.force[:count])) for row in against_hyperelastic(8.0, table) if row.rung == rung
    }
    return max(worst.values()), [name for name, error in worst.items() if error <= bound]


def _worst(rows: list[Row], changes: tuple[Row, ...]) -> SolidRow:
    moved = [row for row in changes if row.indenter == rows[0].indenter]
    costs = sorted(row.cost_ms for row in rows)
    return SolidRow(
        rows[0].rung,
        rows[0].indenter,
        tuple(max(column, key=abs) for column in zip(*(row.force_error for row in rows), strict=True)),
        tuple(map(max, zip(*(row.displacement_error for row in rows), strict=True))),
        tuple(max(map(abs, column)) for column in zip(*(row.force_error for row in moved), strict=True)),
        costs[len(costs) // 2],
    )
