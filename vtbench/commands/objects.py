"""`vtbench objects`: the household objects, what is most like what, and pictures of them."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction
from functools import partial

from vtbench.commands.output import print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, picture, whole_number


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "objects",
        run,
        help="show which household objects are most alike, and draw them",
        about="Objects are compared by what the skin meets of them, at the best turn and shift of one on the other.",
        examples=("vtbench objects --nearest 5", "vtbench objects coin-1-euro", "vtbench objects -o objects.png"),
    )
    parser.add_argument("name", nargs="?", metavar="NAME", help="one object; all of them by default")
    parser.add_argument("--nearest", metavar="N", type=whole_number(1), default=10, help="pairs to print (default 10)")
    parser.add_argument("-o", "--out", metavar="FILE.png", type=picture, help="draw the object, or all of them")
    add_json(parser)


def run(args: Namespace) -> int:
    """Print the nearest pairs; draw when asked to."""
    from sensors import objects

    chosen = objects.get(args.name) if args.name else None
    every = len(objects.names())
    pairs = objects.nearest_pairs(every * (every - 1) // 2)
    if chosen:
        pairs = [(chosen.name, b if a == chosen.name else a, mm) for a, b, mm in pairs if chosen.name in (a, b)]
    rows = [{"object": a, "like": b, "rms_mm": round(mm, 3)} for a, b, mm in pairs[: args.nearest]]
    drawn = None
    if args.out:
        from vtbench.data.files import make_folder, write_whole

        make_folder(args.out.parent)
        draw = partial(objects.draw_object, chosen.name) if chosen else objects.draw_gallery
        write_whole(args.out, draw)
        drawn = args.out
    if args.json:
        about = chosen and {
            "name": chosen.name,
            "title": chosen.title,
            "family": chosen.family,
            "size_mm": chosen.size_mm,
        }
        print_json({"object": about, "nearest": rows, "picture": drawn})
        return 0
    if chosen:
        size = " x ".join(f"{side:g}" for side in chosen.size_mm)
        print(f"{chosen.title} ({chosen.family}, {size} mm): {chosen.description}\n")
    print_table(["object", "like", "rms of heights [mm]"], [list(row.values()) for row in rows])
    if drawn:
        print(f"\ndrawn: {drawn}")
    return 0
