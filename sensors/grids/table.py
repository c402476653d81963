"""The measured errors and costs of the contact grids: rows, and the small JSON file that holds them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from sensors.json_rows import json_rows

TABLE_PATH = Path(__file__).with_name("table.json")
"""The committed table."""

_FORMAT = 1


@dataclass(frozen=True)
class GridRow:
    """A contact model on one grid, of one pad under one class of object: its largest errors, and the median cost.

    `force`: of a taxel, over the whole load. `displacement`: root mean square over that of the reference, of the
    surface that the camera sees. `frame`: root mean square over the 256x256 frame, grey levels, without noise.
    `cost_ms`: CPU of contact, taxels and frame. `contact`: as in the sensor's parameters. `depth_ratio`: the deepest
    indentation of a film on a plate over its thickness, 0 for a hollow skin.
    """

    pad: str
    objects: str
    grid: int
    force: float
    displacement: float
    frame: float
    cost_ms: float
    contact: str = "elastic"
    depth_ratio: float = 0.0


@dataclass(frozen=True)
class GridTable:
    """Rows; the pads (sensor parameters by name) and the loads (N) they were measured with.

    `reference_change` has a row per pad and class: the reference grid against the next finer one.
    """

    pads: dict[str, dict[str, Any]]
    loads_n: tuple[float, ...]
    reference: str
    machine: str
    reference_change: tuple[GridRow, ...]
    rows: tuple[GridRow, ...]


@lru_cache(maxsize=1)
def committed_grids() -> GridTable:
    """The table that comes with the package."""
    return read_grids(TABLE_PATH)


def read_grids(path: Path) -> GridTable:
    """Read a table; ValueError in one line where the file is not one."""
    try:
        data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        if data.pop("format") != _FORMAT:
            raise ValueError(f"format must be {_FORMAT}")
        rows = {name: tuple(GridRow(**row) for row in data.pop(name)) for name in ("reference_change", "rows")}
        return GridTable(data["pads"], tuple(data["loads_n"]), data["reference"], data["machine"], **rows)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(
            f"{path} is not a table of contact grids ({error}); write it anew with `python -m sensors.grids`"
        ) from error


def write_grids(table: GridTable, path: Path) -> None:
    """Write a table as JSON, a line for each row."""
    head = {
        "format": _FORMAT,
        "pads": table.pads,
        "loads_n": table.loads_n,
        "reference": table.reference,
        "machine": table.machine,
    }
    tables = {"reference_change": table.reference_change, "rows": table.rows}
    path.write_text(json_rows(head, tables), encoding="utf-8")
