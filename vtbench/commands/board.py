"""`vtbench board`: records of one or several runs become tables and a page."""

from __future__ import annotations

import sys
from argparse import Namespace, _SubParsersAction
from pathlib import Path
from typing import TYPE_CHECKING

from vtbench.commands.output import count_text, print_json
from vtbench.commands.parser import Parser, add_command, add_json, add_out

if TYPE_CHECKING:
    from leaderboard.record import Record


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "board",
        run,
        help="draw the tables of one or several runs: Markdown, CSV, one offline page",
        examples=("vtbench board out/quick -o out/board", "vtbench board out/fvsight out/texture -o out/board"),
        resume="the same command draws everything again",
    )
    parser.add_argument("runs", metavar="DIR", type=Path, nargs="+", help="folders of runs")
    add_out(parser, "DIR", "folder of the tables and the page")
    add_json(parser)


def run(args: Namespace) -> int:
    """Collect the records and draw."""
    from leaderboard import build_board

    records = collect(args.runs)
    build_board(records, args.out)
    files = sorted(path for path in args.out.rglob("*") if path.is_file())
    if args.json:
        print_json({"out": args.out, "records": len(records), "files": files})
        return 0
    print(f"{args.out}: {count_text(len(records), 'record')}, {count_text(len(files), 'file')}")
    for path in files:
        print(f"  {path}")
    return 0


def collect(runs: list[Path]) -> list[Record]:
    """Records of all runs; of two with the same key the one that finished last.

    Raises:
        ValueError: a folder that is no run, or no record in any of them.
    """
    from leaderboard import scan_records

    newest: dict[str, Record] = {}
    for folder in runs:
        if not folder.is_dir():
            raise ValueError(f"{folder}: expected the folder of a run, found nothing there")
        records, problems = scan_records(folder)
        for problem in problems:
            print(f"vtbench: warning: {problem}", file=sys.stderr)
        for record in records:
            old = newest.get(record.key)
            if old is None or old.provenance.finished <= record.provenance.finished:
                newest[record.key] = record
    if not newest:
        places = ", ".join(map(str, runs))
        raise ValueError(f"{places}: no records to draw; `vtbench run SUITE -o DIR` makes them")
    return list(newest.values())
