"""`vtbench slip-cost`: CPU time of the covariance detector beside plain recomputations."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction
from dataclasses import asdict

from vtbench.commands.output import print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, whole_number


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "slip-cost",
        run,
        help="measure what a sample costs the covariance slip detector, beside plain recomputations",
        about="CPU microseconds a sample on one thread: median of the repeats, least and most behind it. All forms "
        "run in turn\nin every repeat, and `times the batch` is taken within a repeat. `word for word` forms the "
        "differences and the matrix\nof each window anew, as the paper writes them; `lean` differences once and works "
        "in place.\nThe other detectors' cost stands beside their delays on the board of `vtbench run slip`.",
        examples=("vtbench slip-cost", "vtbench slip-cost --window 200 --json"),
    )
    parser.add_argument("--window", metavar="N", type=whole_number(2), default=50, help="in samples (default 50)")
    parser.add_argument("--taxels", metavar="N", type=whole_number(1), default=16, help="of the array (default 16)")
    parser.add_argument("--repeats", metavar="N", type=whole_number(1), default=15, help="rounds (default 15)")
    add_json(parser)


def run(args: Namespace) -> int:
    """Measure and print."""
    from slip.timing import covariance_cost
    from vtbench.data.shards import one_thread

    with one_thread():
        costs = covariance_cost(args.window, args.taxels, args.repeats)
    if args.json:
        from vtbench.environment import fingerprint, machine

        rows = [asdict(cost) for cost in costs]
        print_json(
            {
                "machine": machine(),
                "fingerprint": fingerprint(),
                "threads": 1,
                "window": args.window,
                "taxels": args.taxels,
                "rows": rows,
            }
        )
        return 0
    print(f"covariance detector, window {args.window}, {args.taxels} taxels, {args.repeats} repeats, one thread\n")
    cells = [[cost.form, _spread(cost.us, 2), _spread(cost.ratio, 1)] for cost in costs]
    print_table(["form", "µs a sample", "times the batch"], cells)
    return 0


def _spread(values: tuple[float, float, float], digits: int) -> str:
    median, least, most = values
    return f"{median:,.{digits}f} ({least:,.{digits}f} to {most:,.{digits}f})"
