"""`vtbench show`: a picture of a dataset, of one press, or of recordings."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction

from vtbench.commands.output import print_json
from vtbench.commands.parser import Parser, add_command, add_json, add_out, picture, whole_number


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "show",
        run,
        help="draw a dataset, one of its presses, or public recordings",
        examples=(
            "vtbench show data/paper -o sheet.png",
            "vtbench show data/paper --sample 5 -o press.png",
            "vtbench show data/slip --sample 3 -o scores.png",
            "vtbench show fabricslide16 -o slides.png",
        ),
    )
    parser.add_argument("path", metavar="PATH", help="a dataset, a run, or the name of public recordings")
    add_out(parser, "FILE.png", "picture to write", picture)
    parser.add_argument("--sample", metavar="I", type=whole_number(0), help="draw this press or trial in time, from 0")
    add_json(parser)


def run(args: Namespace) -> int:
    """Draw, and print the picture's path."""
    from vtbench.show import show

    path = show(args.path, args.out, sample=args.sample)
    if args.json:
        print_json({"path": args.path, "picture": path})
    else:
        print(path)
    return 0
