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
    from leaderboard.tally import Tally


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "board",
        run,
        help="draw the tables of one or several runs: Markdown, CSV, one offline page",
        about="Methods are ranked by paired differences where the datasets of the runs are at hand. --baselines adds "
        "the records\nthat come with vtbench, alone or beside runs of your own.",
        examples=(
            "vtbench board out/quick -o out/board",
            "vtbench board out/fvsight out/texture -o out/board",
            "vtbench board --baselines -o out/board",
            "vtbench board out/mine --baselines -o out/board",
        ),
        resume="the same command draws everything again",
    )
    parser.add_argument("runs", metavar="DIR", type=Path, nargs="*", help="folders of runs")
    parser.add_argument("--baselines", action="store_true", help="the records that come with vtbench, too")
    add_out(parser, "DIR", "folder of the tables and the page")
    add_json(parser)


def run(args: Namespace) -> int:
    """Collect the records and draw."""
    from leaderboard import build_board
    from vtbench.run.tallies import run_tallies

    if not args.runs and not args.baselines:
        raise ValueError("expected the folder of a run, or --baselines (`vtbench board --help`)")
    records, problems = collect(args.runs)
    tallies: dict[str, Tally] = {}
    for folder in args.runs:
        found, without = run_tallies(folder, [r for r in records if (folder / "runs" / r.key).is_dir()])
        tallies |= found
        problems += without
    if args.baselines:
        from leaderboard.baselines import read_baselines

        baselines, more = read_baselines()
        here = {(r.key, r.provenance.fingerprint) for r in records}
        records += [r for r in baselines if (r.key, r.provenance.fingerprint) not in here]
        tallies = more | tallies
    for problem in problems:
        print(f"vtbench: warning: {problem}", file=sys.stderr)
    files = build_board(records, args.out, problems=problems, tallies=tallies)
    if args.json:
        told = {"html": files.html, "markdown": files.markdown, "csv": files.csv, "problems": problems}
        print_json({"out": args.out, "records": len(records), **told})
        return 0
    print(f"{args.out}: {count_text(len(records), 'record')}")
    print(f"page      {files.html}\nMarkdown  {files.markdown}")
    print(f"CSV       {count_text(len(files.csv), 'table')} in {args.out / 'csv'}")
    return 0


def collect(runs: list[Path]) -> tuple[list[Record], list[str]]:
    """Records of all runs, and one line for each that cannot be read.

    Raises:
        ValueError: a folder that is no run, or no record in any of them.
    """
    from leaderboard import scan_records

    records: list[Record] = []
    problems: list[str] = []
    for folder in runs:
        if not folder.is_dir():
            raise ValueError(f"{folder}: expected the folder of a run, found nothing there")
        found = scan_records(folder)
        records += found[0]
        problems += found[1]
    if runs and not records:
        broken = f"; {problems[0]}" if problems else ""
        raise ValueError(f"{runs[0]}: no records to draw; `vtbench run SUITE -o DIR` makes them{broken}")
    return records, problems
