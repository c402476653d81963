"""`vtbench compare RUN --paper`: the orderings of the FVSight paper, and whether they hold in this run."""

from __future__ import annotations

from argparse import Namespace
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from vtbench.commands.output import print_json, print_table

if TYPE_CHECKING:
    from leaderboard.orderings import Ordering
    from leaderboard.record import Record
    from leaderboard.tally import Tally

WORDS = ("holds", "reversed", "equal here", "not shown")


def print_orderings(
    records: Sequence[Record], tallies: Mapping[str, Tally], near: Mapping[str, str], args: Namespace
) -> int:
    """Print every ordering that the run can judge, by protocol, reading and backbone.

    Raises:
        ValueError: the run holds no two methods that the paper orders.
    """
    from leaderboard.orderings import orderings

    found = orderings(records, tallies, near, args.margin / 100)
    if not found:
        raise ValueError(
            f"{args.runs[0]}: expected methods that the paper compares (ksc, jksc, knn, svm on force, image and both), "
            "found no pair of them on one protocol"
        )
    if args.json:
        print_json({"runs": args.runs, "margin": args.margin / 100, "rows": [_plain(each) for each in found]})
        return 0
    blocks: dict[tuple[str, ...], list[Ordering]] = {}
    for each in found:
        who = each.result.first.identity
        blocks.setdefault((who.task, who.variant, who.split, each.reading, each.backbone), []).append(each)
    for names, block in blocks.items():
        print("; ".join([", ".join(names[:3]), *filter(None, names[3:])]) + "\n")
        heads = ("better in the paper", "than", "paper, %", "here, %", "difference", "95 % interval", "here", "note")
        print_table(heads, [_row(each) for each in sorted(block, key=lambda each: WORDS.index(each.word))])
        for warning in dict.fromkeys(each.result.coverage for each in block if each.result.coverage):
            print(f"  ≈ {warning}")
        counts = Counter(str(each.word) for each in block)
        print(f"  {', '.join(f'{counts[word]} {word}' for word in WORDS if counts[word])} of {len(block)}\n")
    print("Paired over groups; verdicts Holm-adjusted over the rows of a table, equal within")
    print(
        f"{args.margin:g} points. The paper has one JKSC: `jksc-independent` is its equation, `jksc` (one support for"
    )
    print("both) its source's; that the second beats the first is the source's claim, without a figure.")
    return 0


def _row(each: Ordering) -> tuple[str, ...]:
    from leaderboard.caution import MARK
    from leaderboard.versus import name_of

    result, d = each.result, each.result.comparison.difference
    scores = " : ".join(f"{100 * r.metrics[0].value:.1f}" for r in (result.first, result.second))
    return (
        name_of(result.first),
        name_of(result.second),
        " : ".join(f"{figure:.1f}" for figure in each.paper) if each.paper else "-",
        scores,
        f"{100 * d.value:+.1f}",
        f"{100 * d.low:+.1f} to {100 * d.high:+.1f}",
        each.word,
        ("" if result.paired else "unpaired ") + (MARK if result.coverage else ""),
    )


def _plain(each: Ordering) -> dict[str, Any]:
    from leaderboard.versus import name_of

    result, d = each.result, each.result.comparison.difference
    who = result.first.identity
    return {
        "task": who.task,
        "variant": who.variant,
        "split": who.split,
        "reading": each.reading,
        "backbone": each.backbone,
        "better_in_paper": name_of(result.first),
        "than": name_of(result.second),
        "paper_percent": each.paper,
        "values": [result.first.metrics[0].value, result.second.metrics[0].value],
        "difference": d.value,
        "low": d.low,
        "high": d.high,
        "groups": d.groups,
        "paired": result.paired,
        "p_holm": result.verdict.p,
        "word": each.word,
        "coverage_warning": result.coverage,
    }
