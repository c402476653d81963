"""`vtbench frame-cost`: CPU time of one paired press frame by stage."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction

from vtbench.commands.output import count_text, print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, whole_number


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "frame-cost",
        run,
        help="measure what one paired press frame costs, by stage",
        about="CPU milliseconds on one thread, over presses of all objects. `frame total` is one contact solve, the "
        "taxels and\nthe rendered frame, without encoding; the force history of a press and a contact solve that "
        "starts from 95 % of the\nload (warm) are apart. Then come a frame of a slip trial with its part of the forces,"
        "\none second of friction and electronics of 16 taxels, and how much faster two processes press than one.",
        examples=("vtbench frame-cost", "vtbench frame-cost --repeats 10 --json"),
    )
    parser.add_argument("--repeats", metavar="N", type=whole_number(1), default=3, help="rounds (default 3)")
    add_json(parser)


def run(args: Namespace) -> int:
    """Measure and print."""
    from sensors.scaling import two_processes
    from sensors.timing import frame_cost

    rows = frame_cost(args.repeats)
    scaling = two_processes(args.repeats)
    if args.json:
        from vtbench.environment import fingerprint, machine

        print_json(
            {"machine": machine(), "fingerprint": fingerprint(), "threads": 1, "rows": rows, "two_processes": scaling}
        )
        return 0
    print_table([name.replace("ms_", "ms ") for name in rows[0]], [list(row.values()) for row in rows])
    print(
        f"\ntwo processes press {scaling['ratio']:.2f} times as fast as one ({scaling['low']:.2f} to "
        f"{scaling['high']:.2f}, {count_text(scaling['rounds'], 'round')}; wall time, so other load shows)"
    )
    return 0
