"""Which contact grid a press scene needs: measured errors of 64, 128 and 256 cells, and the cheapest within a bound.

`python -m sensors.grids` measures again and rewrites the committed table.
"""

from sensors.grids.choose import GridChoice, choose_grid, refuse_deeper
from sensors.grids.table import GridRow, GridTable, committed_grids, read_grids, write_grids

__all__ = [
    "GridChoice",
    "GridRow",
    "GridTable",
    "choose_grid",
    "committed_grids",
    "read_grids",
    "refuse_deeper",
    "write_grids",
]
