"""Measure the contact ladder again: `python -m sensors.contact.ladder [-o TABLE.json]`."""

from __future__ import annotations

import argparse
from pathlib import Path

from threadpoolctl import threadpool_limits

from sensors.contact.ladder.measure import measure_ladder
from sensors.contact.ladder.table import TABLE_PATH, write_table


def main() -> None:
    """Print a line per rung, pad and indenter, and write the table."""
    parser = argparse.ArgumentParser(prog="python -m sensors.contact.ladder", description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=TABLE_PATH, help="file to write (default: the committed one)")
    out = parser.parse_args().out
    with threadpool_limits(1):
        table = measure_ladder(report=lambda line: print(line, flush=True))
    write_table(table, out)
    print(f"d/h {table.depth_ratios}; reference: {table.reference}; {table.machine}; wrote {out}")


if __name__ == "__main__":
    main()
