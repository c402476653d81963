"""`vtbench compare RUN --from VARIANT`: what a method loses from one variant of a task to another, paired."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from vtbench.commands.output import count_text, print_json, print_table

if TYPE_CHECKING:
    from leaderboard.record import Record
    from leaderboard.tally import Tally
    from leaderboard.versus import Versus

WORDS = {"first better": "better", "second better": "worse", "equivalent": "the same", "undecided": "undecided"}


def print_changes(
    records: Sequence[Record], tallies: Mapping[str, Tally], near: Mapping[str, str], args: Namespace
) -> int:
    """Print a table for each variant and split, the best method there first.

    Raises:
        ValueError: a variant or method that is not there.
    """
    from leaderboard.versus import across, compare_pairs

    pairs = across(records, args.start, args.methods)
    rows = compare_pairs(pairs, (dict(tallies), dict(tallies)), near, args.margin / 100)
    if args.json:
        print_json({"run": args.runs[0], "from": args.start, "margin": args.margin / 100, "rows": _plain(rows)})
        return 0
    blocks: dict[tuple[str, ...], list[Versus]] = {}
    for row in rows:
        who = row.first.identity
        blocks.setdefault((who.task, who.split, who.dataset, who.variant), []).append(row)
    for (task, split, _, variant), block in blocks.items():
        print(f"{task}, {split}: from {args.start} to {variant}\n")
        heads = ("method", f"{args.start}, %", f"{variant}, %", "difference", "95 % interval", "verdict", "note")
        print_table(heads, [_row(row) for row in block])
        for warning in dict.fromkeys(row.coverage for row in block if row.coverage):
            print(f"  ≈ {warning}")
        print()
    print(f"{count_text(len(rows), 'difference')}, a method against itself, paired over groups; verdicts Holm-adjusted")
    print(
        f"by table, `the same` within {args.margin:g} points. Methods on one variant against each other: without --from"
    )
    return 0


def _row(row: Versus) -> tuple[str, ...]:
    from leaderboard.caution import MARK
    from leaderboard.versus import name_of

    d = row.comparison.difference
    return (
        name_of(row.first),
        f"{100 * row.second.metrics[0].value:.1f}",
        f"{100 * row.first.metrics[0].value:.1f}",
        f"{100 * d.value:+.1f}",
        f"{100 * d.low:+.1f} to {100 * d.high:+.1f}",
        WORDS[row.verdict.word],
        ("" if row.paired else "unpaired ") + (MARK if row.coverage else ""),
    )


def _plain(rows: Sequence[Versus]) -> list[dict[str, Any]]:
    made = []
    for row in rows:
        who, d = row.first.identity, row.comparison.difference
        made.append(
            {
                "task": who.task,
                "variant": who.variant,
                "split": who.split,
                "dataset_hash": who.dataset_hash,
                "method": who.method,
                "modality": who.modality,
                "keys": [row.second.key, row.first.key],
                "values": [row.second.metrics[0].value, row.first.metrics[0].value],
                "difference": d.value,
                "low": d.low,
                "high": d.high,
                "interval": d.method,
                "groups": d.groups,
                "paired": row.paired,
                "p_holm": row.verdict.p,
                "verdict": WORDS[row.verdict.word],
                "coverage_warning": row.coverage,
            }
        )
    return made
