"""`vtbench compare`: methods of one run, or the same cells of two, told apart as far as the samples allow."""

from __future__ import annotations

import sys
from argparse import ArgumentTypeError, Namespace, _SubParsersAction
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vtbench.commands.output import count_text, print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json

if TYPE_CHECKING:
    from leaderboard.record import Record
    from leaderboard.tally import Tally
    from leaderboard.versus import Versus

MOST_RUNS = 2


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "compare",
        run,
        help="compare methods on the same samples: difference, equivalence, cost",
        about="One run: the methods named, or the best of each protocol against the others. Two runs: the same cells, "
        "or the first\nname in the first run against the second name in the second. Differences are paired over groups "
        "(presses, units,\nsettings); verdicts are adjusted over all pairs of a protocol (Holm). `equivalent` means "
        "surely closer than the margin\n(two one-sided tests). Speeds of different machines are not compared.",
        examples=(
            "vtbench compare out/quick --task objects/deep/v1",
            "vtbench compare out/quick --methods ksc@force svm@force",
            "vtbench compare out/before out/after --margin 1",
            "vtbench compare out/fvsight --paper",
            "vtbench compare out/nets --task robustness/v1 --from clean",
        ),
    )
    parser.add_argument(
        "runs", metavar="RUN", type=Path, nargs="+", help="folder of a run; a second one to compare with"
    )
    parser.add_argument("--task", metavar="T", nargs="+", default=[], help="only these tasks")
    parser.add_argument("--split", metavar="S", nargs="+", default=[], help="only these splits")
    parser.add_argument("--methods", metavar="M", nargs="+", default=[], help="method@modality, or a record's key")
    parser.add_argument(
        "--paper", action="store_true", help="which of the FVSight paper's orderings hold in this run, and which do not"
    )
    parser.add_argument(
        "--from",
        dest="start",
        metavar="VARIANT",
        help="what each method gains or loses from this variant of its task to every other, such as robustness/v1's "
        "clean",
    )
    parser.add_argument(
        "--margin",
        metavar="POINTS",
        type=_points,
        default=2.0,
        help="equivalence margin, percentage points (default 2)",
    )
    add_json(parser)


def _points(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < 100:
        raise ArgumentTypeError(f"expected percentage points between 0 and 100, got {text!r}")
    return value


def run(args: Namespace) -> int:
    """Compare and print."""
    from leaderboard.audit import reached
    from leaderboard.frame import records_frame
    from leaderboard.versus import between, compare_pairs, with_best, within

    if len(args.runs) > MOST_RUNS:
        raise ValueError(f"expected one run or two, got {len(args.runs)}")
    runs = [_read(folder, args) for folder in args.runs]
    near: dict[str, str] = {}
    for records, _ in runs:
        near |= reached(records_frame(records))
    kept = [_kept(records, args) for records, _ in runs]
    if args.start is not None:
        from vtbench.commands.compare_variants import print_changes

        if len(runs) != 1 or args.paper:
            raise ValueError("--from compares the variants of one run; leave --paper and a second run out")
        return print_changes(kept[0], runs[0][1], near, args)
    if args.paper:
        from vtbench.commands.compare_paper import print_orderings

        if len(runs) != 1 or args.methods:
            raise ValueError("--paper compares the methods that the paper names within one run; leave the rest out")
        return print_orderings(kept[0], runs[0][1], near, args)
    pairs = within(kept[0], args.methods) if len(runs) == 1 else between(kept[0], kept[1], args.methods)
    if not pairs:
        raise ValueError(f"{args.runs[0]}: expected two scored methods of one protocol to compare, found fewer")
    rows = compare_pairs(pairs, (runs[0][1], runs[-1][1]), near, args.margin / 100)
    if len(runs) == 1 and not args.methods:
        rows = with_best(rows)
    if args.json:
        print_json({"runs": args.runs, "margin": args.margin / 100, "rows": [_plain(row) for row in rows]})
        return 0
    _print(rows, args.margin)
    return 0


def _read(folder: Path, args: Namespace) -> tuple[list[Record], dict[str, Tally]]:
    """All records of a run and their tallies; what cannot be read is a warning."""
    from leaderboard import scan_records
    from vtbench.run.tallies import run_tallies

    if not folder.is_dir():
        raise ValueError(f"{folder}: expected the folder of a run, found nothing there")
    records, problems = scan_records(folder)
    chosen = [r for r in records if not args.task or r.identity.task in args.task]
    tallies, without = run_tallies(folder, chosen)
    for problem in (*problems, *without):
        print(f"vtbench: warning: {problem}", file=sys.stderr)
    if not records:
        raise ValueError(f"{folder}: no records to compare; `vtbench run SUITE -o DIR` makes them")
    return records, tallies


def _kept(records: list[Record], args: Namespace) -> list[Record]:
    """Records of the tasks and splits asked for."""
    for asked, field in ((args.task, "task"), (args.split, "split")):
        there = {getattr(record.identity, field) for record in records}
        for name in asked:
            if name not in there:
                raise ValueError(f"no record of the {field} {name!r}; there is {', '.join(sorted(there))}")
    return [
        record
        for record in records
        if (not args.task or record.identity.task in args.task)
        and (not args.split or record.identity.split in args.split)
    ]


def _print(rows: Sequence[Versus], margin: float) -> None:
    from leaderboard.caution import MARK
    from leaderboard.versus import measured, name_of

    blocks: dict[tuple[str, str, str], list[Versus]] = {}
    for row in rows:
        who = row.first.identity
        blocks.setdefault((who.task, who.variant, who.split), []).append(row)
    for (task, variant, split), block in blocks.items():
        print(f"{task}, {variant}, {split}\n")
        heads = ("first", "%", "second", "%", "difference", "95 % interval", "verdict", "time ratio", "note")
        table = []
        for row in block:
            d = row.comparison.difference
            interval = f"{100 * d.low:+.1f} to {100 * d.high:+.1f}"
            scores = [f"{100 * r.metrics[0].value:.1f}" for r in (row.first, row.second)]
            ratio = row.cost_note if row.cost_ratio is None else _ratio(row.cost_ratio)
            marks = ("" if row.paired else "unpaired ") + (MARK if row.coverage else "") + ("⚠" if row.probes else "")
            names = name_of(row.first), name_of(row.second)
            difference = f"{100 * d.value:+.1f}"
            table.append(
                (names[0], scores[0], names[1], scores[1], difference, interval, row.verdict.word, ratio, marks)
            )
        print_table(heads, table)
        for warning in dict.fromkeys(row.coverage for row in block if row.coverage):
            print(f"  {MARK} {warning}")
        for warning in dict.fromkeys(said for row in block for said in row.probes):
            print(f"  ⚠ {warning}")
        print()
    print(f"{count_text(len(rows), 'pair')}; verdicts Holm-adjusted by protocol, equivalent within {margin:g} points;")
    ways = {measured(row.first) for row in rows if row.cost_ratio is not None}
    how = {True: "by `vtbench time`", False: "during the run"}
    taken = " or ".join(how[way] for way in sorted(ways)) or "during the run"
    print(f"time ratio: first over second, method and features, as timed {taken}")


def _ratio(value: float) -> str:
    return f"{value:,.0f}" if value >= 10 else f"{value:.2g}"


def _plain(row: Versus) -> dict[str, Any]:
    who, c, d = row.first.identity, row.comparison, row.comparison.difference
    sides = {
        side: {
            "key": record.key,
            "method": record.identity.method,
            "modality": record.identity.modality,
            "value": record.metrics[0].value,
        }
        for side, record in (("first", row.first), ("second", row.second))
    }
    return {
        "task": who.task,
        "variant": who.variant,
        "split": who.split,
        "dataset_hash": who.dataset_hash,
        **sides,
        "difference": d.value,
        "low": d.low,
        "high": d.high,
        "interval": d.method,
        "groups": d.groups,
        "paired": row.paired,
        "p": c.p,
        "p_equivalent": c.p_equivalent,
        "p_holm": row.verdict.p,
        "p_equivalent_holm": row.verdict.p_equivalent,
        "verdict": row.verdict.word,
        "coverage_warning": row.coverage,
        "probe_warnings": row.probes,
        "cost_ratio": row.cost_ratio,
        "cost_note": row.cost_note,
    }
