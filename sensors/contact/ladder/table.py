"""The measured errors and costs of the rungs: rows, and the small JSON file that holds them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sensors.json_rows import json_rows

TABLE_PATH = Path(__file__).with_name("table.json")
"""The committed table."""

_FORMAT = 1


@dataclass(frozen=True)
class Row:
    """One rung on one pad under one class of indenter.

    Errors are per depth of the table: `force_error` signed, relative to the reference; `displacement_error` the root
    mean square difference of the top's displacement over that of the reference. `cost_ms` is CPU a step of a warm path.
    """

    poisson_ratio: float
    side_ratio: float
    indenter: str
    rung: str
    force_error: tuple[float, ...]
    displacement_error: tuple[float, ...]
    cost_ms: float


@dataclass(frozen=True)
class LadderTable:
    """Rows over `depth_ratios` (d/h), and how far the reference itself still moves.

    `reference_change` has a row per Poisson's ratio and class: the reference mesh against the next coarser one.
    """

    depth_ratios: tuple[float, ...]
    reference: str
    machine: str
    reference_change: tuple[Row, ...]
    rows: tuple[Row, ...]


def committed_table() -> LadderTable:
    """The table that comes with the package."""
    return read_table(TABLE_PATH)


def read_table(path: Path) -> LadderTable:
    """Read a table; ValueError in one line where the file is not one."""
    try:
        data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        if data.pop("format") != _FORMAT:
            raise ValueError(f"format must be {_FORMAT}")
        table = LadderTable(
            tuple(data.pop("depth_ratios")),
            data.pop("reference"),
            data.pop("machine"),
            tuple(map(_row, data.pop("reference_change"))),
            tuple(map(_row, data.pop("rows"))),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(
            f"{path} is not a ladder table ({error}); write it anew with `python -m sensors.contact.ladder`"
        ) from error
    depths = len(table.depth_ratios)
    for row in table.rows + table.reference_change:
        if len(row.force_error) != depths or len(row.displacement_error) != depths:
            raise ValueError(f"{path}: row {row.rung}, {row.indenter} must hold {depths} errors of each kind")
    return table


def _row(data: dict[str, Any]) -> Row:
    errors = {name: tuple(data[name]) for name in ("force_error", "displacement_error")}
    return Row(**{**data, **errors})


def write_table(table: LadderTable, path: Path) -> None:
    """Write a table as JSON, a line for each row."""
    head = {
        "format": _FORMAT,
        "depth_ratios": table.depth_ratios,
        "reference": table.reference,
        "machine": table.machine,
    }
    tables = {"reference_change": table.reference_change, "rows": table.rows}
    path.write_text(json_rows(head, tables), encoding="utf-8")
