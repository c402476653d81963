"""`vtbench time`: what a sample costs, in fresh processes, one at a time, with a control."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vtbench.commands.output import print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, add_out, whole_number

if TYPE_CHECKING:
    from vtbench.run.suite import Suite
    from vtbench.timing.subject import Subject

PROCESSES = 10
SUPPORTED = 6
"""Processes from which on order statistics give a 95 % interval of the median."""


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "time",
        run,
        help="time the methods of a suite, serially, in fresh processes",
        about="Every method of the suite and every network that feeds it, one process at a time on one thread, "
        "interleaved in another\norder each round; loading and the first calls apart. Prints the median of the "
        "process medians with its interval,\nand a control: one method timed as if it were two. Samples stay in "
        "DIR/timings and are not taken twice;\nthe records of DIR get the figures, of a task with several protocols "
        "those of its first. Parameters,\nmultiply-accumulates of one sample (Conv, MatMul, Gemm) and kB are counted "
        "in the ONNX graph, which a classifier\nhas from the features on. Leave the machine alone meanwhile.",
        examples=(
            "vtbench time quick -o out/quick",
            "vtbench time quick -o out/quick --only svm --processes 20",
        ),
        resume="the same command goes on with the processes that are missing",
    )
    parser.add_argument("suite", metavar="SUITE", help="name or YAML file of the suite that was run")
    add_out(parser, "DIR", "folder of its finished run")
    parser.add_argument(
        "--processes", metavar="N", type=whole_number(2), default=PROCESSES, help=f"a subject (default {PROCESSES})"
    )
    parser.add_argument("--only", metavar="TEXT", help="time only what has this text in its name")
    parser.add_argument("--fresh", action="store_true", help="drop the samples of this machine and take them again")
    add_json(parser)


def run(args: Namespace) -> int:
    """Time what is missing and print the table."""
    import shutil

    from vtbench.config import load_suite
    from vtbench.environment import fingerprint, machine
    from vtbench.timing import report
    from vtbench.timing.schedule import collect

    suite, out = load_suite(args.suite), args.out
    subjects = _subjects(suite, args.suite, out, args.only)
    folder = out / "timings" / fingerprint()
    if args.fresh:
        shutil.rmtree(folder, ignore_errors=True)
    samples = collect(subjects, out, folder, args.processes)
    table, control = report.rows(subjects, samples), report.control(subjects, samples)
    path = report.write_csv(folder, table)
    changed = report.into_records(out, subjects, samples)
    if args.json:
        print_json({"machine": machine(), "fingerprint": fingerprint(), "rows": table, "control": control})
        return 0
    print_table(_HEAD, [_cells(row) for row in table])
    if args.processes < SUPPORTED:
        print(f"\nintervals of {args.processes} processes are their range and cover less than 95 %; {SUPPORTED} do")
    if control is not None:
        said = "alike" if control["alike"] else "NOT alike: something else ran, trust no difference of this size"
        ratio = f"{control['ratio']:.3f} ({control['low']:.3f} to {control['high']:.3f})"
        print(f"\ncontrol, {control['what']} timed as two: ratio {ratio}, {said}")
    print(f"{len(subjects)} subjects x {args.processes} processes; samples and {path.name} in {folder}")
    print(f"{changed} records of {out} carry these figures now")
    return 0


_COUNTS = ("params", "MACs", "kB")
_HEAD = (
    "what",
    "us, one",
    "95 %",
    "least",
    "p95",
    "us, batch",
    "batch",
    "first call us",
    "load s",
    "peak MB",
    *_COUNTS,
)


def _cells(row: dict[str, Any]) -> list[str]:
    return [
        row["what"],
        f"{row['us_one']:,.1f}",
        f"{row['us_one_low']:,.1f} to {row['us_one_high']:,.1f}",
        f"{row['us_one_least']:,.1f}",
        f"{row['us_one_p95']:,.1f}",
        f"{row['us_batch']:,.2f}",
        str(row["batch"]),
        f"{row['first_call_us']:,.0f}",
        f"{row['load_s']:.2f}",
        f"{row['peak_mb']:,.0f}",
        *("-" if row[name] is None else f"{row[name]:,.0f}" for name in ("params", "macs", "kb")),
    ]


def _subjects(suite: Suite, named: str, out: Path, only: str | None) -> list[Subject]:
    """What there is to time in a finished run.

    Raises:
        ValueError: no run of this suite there, one that is not finished, or nothing of that name.
    """
    from leaderboard.record import read_records
    from vtbench.run.folder import read_suite
    from vtbench.run.planned import planned
    from vtbench.timing.subject import subjects_of

    there = read_suite(out)
    if there.id != suite.id:
        raise ValueError(f"{out}: holds a run of the suite {there.id!r}, not of {suite.id!r}")
    cells = planned(there, out)
    records = {record.key: record.status.state for record in read_records(out)}
    if missing := sum(cell.key not in records for cell in cells):
        again = f"`vtbench run {named} -o {out}` goes on"
        raise ValueError(f"{out}: {missing} of {len(cells)} cells are not run yet; {again}")
    done = {key for key, state in records.items() if state == "ok"}
    if not (every := subjects_of(cells, done)):
        raise ValueError(f"{out}: no method of this run has a result, so there is nothing to time")
    if not (found := subjects_of(cells, done, only or "")):
        names = list(dict.fromkeys(subject.name for subject in every))
        more = f" and {len(names) - 4} more" if len(names) > 4 else ""
        raise ValueError(f"{out}: no name holds {only!r}; there are {', '.join(map(repr, names[:4]))}{more}")
    return found
