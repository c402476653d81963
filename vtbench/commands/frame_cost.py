"""`vtbench frame-cost`: CPU time of one paired press frame by stage."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction

from vtbench.commands.output import print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, whole_number


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "frame-cost",
        run,
        help="measure what one paired press frame costs, by stage",
        about="CPU milliseconds on one thread, over presses of all objects. `frame total` is one contact solve, the "
        "taxels and\nthe rendered frame, without encoding; the force history of a press is apart.\nThe last rows "
        "are one second of friction and electronics of 16 taxels.",
        examples=("vtbench frame-cost", "vtbench frame-cost --repeats 10 --json"),
    )
    parser.add_argument("--repeats", metavar="N", type=whole_number(1), default=3, help="rounds (default 3)")
    add_json(parser)


def run(args: Namespace) -> int:
    """Measure and print."""
    from sensors.timing import frame_cost

    rows = frame_cost(args.repeats)
    if args.json:
        from vtbench.environment import fingerprint, machine

        print_json({"machine": machine(), "fingerprint": fingerprint(), "threads": 1, "rows": rows})
        return 0
    print_table([name.replace("ms_", "ms ") for name in rows[0]], [list(row.values()) for row in rows])
    return 0
