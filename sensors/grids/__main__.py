"""Measure the contact grids again: `python -m sensors.grids [-o TABLE.json]`."""

from __future__ import annotations

import argparse
from pathlib import Path

from threadpoolctl import threadpool_limits

from sensors.grids.measure import measure_grids
from sensors.grids.table import TABLE_PATH, write_grids


def main() -> None:
    """Print a line per grid, pad and class of object, and write the table."""
    parser = argparse.ArgumentParser(prog="python -m sensors.grids", description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=TABLE_PATH, help="file to write (default: the committed one)")
    out = parser.parse_args().out
    with threadpool_limits(1):
        table = measure_grids(report=lambda line: print(line, flush=True))
    write_grids(table, out)
    print(f"reference: {table.reference}; {table.machine}; wrote {out}")


if __name__ == "__main__":
    main()
