"""`vtbench run` and `vtbench score`: a suite's cells, and their scores taken again."""

from __future__ import annotations

import sys
from argparse import Namespace, _SubParsersAction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vtbench.commands.check import suite_problems
from vtbench.commands.output import count_text, print_json
from vtbench.commands.parser import Parser, add_command, add_jobs, add_json, add_out, add_scheduler

if TYPE_CHECKING:
    from leaderboard.record import Record
    from vtbench.run import RunSummary

PARTS_FAILED = 1


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare both commands."""
    parser = add_command(
        commands,
        "run",
        run,
        help="run a suite: datasets, features, classifiers, records",
        about="Killed at any moment, the same command goes on; a finished suite does no work. Exits with 1 when a cell "
        "failed\nor a law did not hold.",
        examples=(
            "vtbench run quick -o out/quick --jobs 2",
            "vtbench run my-suite.yaml -o out/mine",
            "vtbench run quick -o out/quick --fresh",
        ),
        resume="the same command goes on with the cells that are missing",
    )
    parser.add_argument("suite", metavar="SUITE", help="name (`vtbench list suites`) or a YAML file of your own")
    add_out(parser, "DIR", "folder of the run")
    parser.add_argument(
        "--fresh", action="store_true", help="run every cell again; datasets, features and submissions are kept"
    )
    parser.add_argument("--device", default="cpu", help="where networks run (default cpu)")
    add_jobs(parser)
    add_scheduler(parser)
    add_json(parser)

    parser = add_command(
        commands,
        "score",
        score,
        help="score a run again from its prediction files, without running a model",
        examples=("vtbench score out/quick", "vtbench score out/quick --json"),
    )
    parser.add_argument("run_dir", metavar="DIR", type=Path, help="folder of a run")
    add_json(parser)


def run(args: Namespace) -> int:
    """Run what is missing of the suite and print its tables."""
    from vtbench.config import load_suite
    from vtbench.run import run_suite
    from vtbench.scheduling import connect

    suite = load_suite(args.suite)
    for problem in suite_problems(suite):
        raise ValueError(f"{args.suite}: {problem}")
    with connect(args.scheduler) as cluster:
        summary = run_suite(suite, args.out, jobs=args.jobs, cluster=cluster, fresh=args.fresh, device=args.device)
    if args.json:
        print_json(_summary(summary))
        return _code(summary)
    print(_tables(summary), *summary.lines(), sep="\n")
    print(f"page: vtbench board {args.out} -o {args.out / 'board'}")
    return _code(summary)


def score(args: Namespace) -> int:
    """Score predictions again and print the tables."""
    from vtbench.run import rescore

    summary = rescore(args.run_dir)
    if args.json:
        print_json(_summary(summary))
        return _code(summary)
    print(_tables(summary))
    print(f"{args.run_dir}: {count_text(summary.done, 'cell')} scored again in {summary.seconds:.1f} s")
    return _code(summary)


def _tables(summary: RunSummary) -> str:
    """The tables of the page that `vtbench board` draws of this folder: all its records, paired in the same way."""
    from leaderboard import board_tables, format_console, scan_records
    from vtbench.run.tallies import run_tallies

    if not summary.records:
        return ""
    records, problems = scan_records(summary.path)
    tallies, unpaired = run_tallies(summary.path, records)
    problems += unpaired
    for problem in problems:
        print(f"vtbench: warning: {problem}", file=sys.stderr)
    return format_console(board_tables(records, problems, tallies))


def _code(summary: RunSummary) -> int:
    return PARTS_FAILED if summary.failed or summary.timeout or summary.broken_laws else 0


def _summary(summary: RunSummary) -> dict[str, Any]:
    counts = ("path", "total", "done", "kept", "skipped", "failed", "timeout")
    return {
        **{name: getattr(summary, name) for name in counts},
        "seconds": round(summary.seconds, 3),
        "broken_laws": [record.key for record in summary.broken_laws],
        "records": [_row(record) for record in summary.records],
    }


def _row(record: Record) -> dict[str, Any]:
    """A record as one flat row: identity, state, and its first metric."""
    identity = record.identity
    metric = record.metrics[0] if record.metrics else None
    return {
        "key": record.key,
        "task": identity.task,
        "variant": identity.variant,
        "split": identity.split,
        "modality": identity.modality,
        "method": identity.method,
        "role": identity.role,
        "kind": identity.kind,
        "state": record.status.state,
        "reason": record.status.reason,
        "metric": metric and metric.name,
        "value": metric and metric.value,
        "low": metric and metric.low,
        "high": metric and metric.high,
        "n": metric and metric.n,
        "interval": metric and metric.interval,
    }
