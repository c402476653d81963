"""`vtbench convert`: a dataset in somebody else's layout."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction
from pathlib import Path

from vtbench.commands.output import count_text, print_json
from vtbench.commands.parser import Parser, add_command, add_json, add_out, one_of

LAYOUTS = ("lerobot",)


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "convert",
        run,
        help="write a dataset in another layout: LeRobot v3.0",
        about="Each recording becomes an episode whose frames hold the image, the forces of the taxels and the task\n"
        "in words. A press has two frames, before contact and at the hold, one nominal second apart; a slide has\n"
        "those of its camera, or every sample of its forces. There is no action: nothing moves the sensor.",
        examples=("vtbench convert data/paper --to lerobot -o data/paper-lerobot",),
        resume="the output is whole or absent: run the same command again",
    )
    parser.add_argument("dataset", metavar="DIR", type=Path, help="a dataset (`vtbench generate`, `vtbench import`)")
    parser.add_argument("--to", metavar="LAYOUT", type=one_of("layout", LAYOUTS), required=True, help="lerobot")
    add_out(parser, "DIR", "folder to make")
    add_json(parser)


def run(args: Namespace) -> int:
    """Convert; print what came of it."""
    import json

    from vtbench.data.lerobot import write_lerobot
    from vtbench.data.opening import open_dataset

    dataset = open_dataset(args.dataset)
    path = write_lerobot(dataset, args.out)
    info = json.loads((path / "meta" / "info.json").read_text(encoding="utf-8"))
    counts = {name: info[f"total_{name}"] for name in ("episodes", "frames", "tasks")}
    if args.json:
        print_json({"path": path, "layout": f"LeRobot {info['codebase_version']}", "fps": info["fps"], **counts})
        return 0
    words = ", ".join(count_text(count, name.removesuffix("s")) for name, count in counts.items())
    print(f"{path}: LeRobot {info['codebase_version']}, {words}, {info['fps']} frames a second")
    return 0
