"""`vtbench sparse-cost`: what kernel sparse coding costs, beside its memory floor and other implementations."""

from __future__ import annotations

import sys
from argparse import Namespace, _SubParsersAction
from dataclasses import asdict
from typing import TYPE_CHECKING

from vtbench.commands.output import print_json, print_table, size_text
from vtbench.commands.parser import Parser, add_command, add_json, whole_number

if TYPE_CHECKING:
    from fusion.timing import Cost

MEMORY_GOAL = 2e9
MEMORY_QUERIES, MEMORY_ATOMS = 100_000, 5000
SIZES = (324, 1000, 5000)


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "sparse-cost",
        run,
        help="measure what a query costs kernel sparse coding, beside its memory floor and other implementations",
        about="CPU microseconds a query: median of the repeats, least and most behind it. All forms run in turn in "
        "every repeat, and\nratios are taken within a repeat; two threads against one is wall time. The replay floor "
        "reads the Gram rows of all\nselected atoms at each step, k (k - 1) / 2 a query, and nothing else; the lower "
        "floor reads each row once, as\nours does beside rows of its own. Ours is timed on matrices that were checked "
        "before, as they are in KSC; its public\nfunction, which checks all of both at each call, has its own row, and "
        "peers run through their public functions.\n`support` is the share of queries with our support, `coefs` the "
        "largest difference of coefficients there. Each\ndictionary is printed once it is measured. --memory measures "
        "the peak of a process that predicts 100,000 queries\nagainst 5,000 atoms instead.",
        examples=(
            "vtbench sparse-cost",
            "vtbench sparse-cost --atoms 324 --repeats 50 --json",
            "vtbench sparse-cost --memory",
        ),
    )
    parser.add_argument(
        "--atoms", metavar="N", type=whole_number(2), nargs="+", default=list(SIZES), help="(default 324 1000 5000)"
    )
    parser.add_argument("--nonzeros", metavar="K", type=whole_number(1), default=10, help="of a code (default 10)")
    parser.add_argument("--repeats", metavar="N", type=whole_number(1), default=15, help="rounds (default 15)")
    parser.add_argument("--memory", action="store_true", help="measure peak memory instead of time")
    parser.add_argument("--threads", metavar="N", type=whole_number(1), default=2, help="of --memory (default 2)")
    add_json(parser)


def run(args: Namespace) -> int:
    """Measure and print."""
    from vtbench.environment import fingerprint, machine

    about: dict[str, object] = {"machine": machine(), "fingerprint": fingerprint()}
    if args.memory:
        return _memory(args, about)
    if args.nonzeros > min(args.atoms):
        raise ValueError(
            f"--nonzeros {args.nonzeros}: a code holds no more atoms than the dictionary, and --atoms asks for one of "
            f"{min(args.atoms)}; lower --nonzeros"
        )
    from fusion.timing import sparse_cost
    from vtbench.data.shards import one_thread

    costs: list[Cost] = []
    if not args.json:
        print(f"codes of {args.nonzeros} atoms, RBF kernel, 28 columns, {args.repeats} repeats in turn")
    for n_atoms in args.atoms:
        with one_thread():
            measured = sparse_cost(n_atoms, args.nonzeros, args.repeats)
        costs += measured
        if not args.json:
            _print_costs(measured)
    if args.json:
        rows = [{**asdict(cost), "met": cost.met} for cost in costs]
        print_json({**about, "n_nonzero_coefs": args.nonzeros, "repeats": args.repeats, "rows": rows})
        return 0
    if not any(cost.form.startswith("dictlearn") for cost in costs):
        print("\ndictlearn is not installed (`pip install 'vtbench[peers]'`): its rows are missing.")
    return 0


def _print_costs(costs: list[Cost]) -> None:
    print()
    print_table(
        ["atoms", "form", "CPU µs a query", "ratio", "", "goal", "support", "coefs"],
        [
            [
                cost.atoms,
                cost.form,
                _spread(cost.us),
                _spread(cost.ratio) if cost.ratio else "",
                cost.of,
                _goal(cost.goal, cost.most, cost.met),
                "" if cost.same_support is None else f"{cost.same_support:.3f}",
                "" if cost.coef_difference is None else f"{cost.coef_difference:.0e}",
            ]
            for cost in costs
        ],
    )
    sys.stdout.flush()


def _memory(args: Namespace, about: dict[str, object]) -> int:
    from fusion.peak_memory import peak_memory

    figures = peak_memory(MEMORY_QUERIES, MEMORY_ATOMS, args.threads)
    met = figures["peak_bytes"] < MEMORY_GOAL
    if args.json:
        asked = {"queries": MEMORY_QUERIES, "atoms": MEMORY_ATOMS, "threads": args.threads}
        print_json({**about, **asked, **figures, "goal_bytes": MEMORY_GOAL, "met": met})
        return 0
    print(
        f"{MEMORY_QUERIES:,} queries against {MEMORY_ATOMS:,} atoms, {args.threads} threads: peak "
        f"{size_text(int(figures['peak_bytes']))} (goal: below {size_text(int(MEMORY_GOAL))}, "
        f"{'met' if met else 'missed'}), {figures['seconds']:.1f} s"
    )
    return 0


def _goal(goal: float | None, most: bool, met: bool | None) -> str:
    return "" if goal is None else f"{'<=' if most else '>='} {goal:g}, {'met' if met else 'missed'}"


def _spread(values: tuple[float, float, float]) -> str:
    median, least, most = (f"{value:.3g}" if value < 100 else f"{value:.0f}" for value in values)
    return f"{median} ({least}–{most})"
