"""`vtbench env`: what a figure depends on outside the code."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction
from typing import Any

from vtbench.commands.output import print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "env",
        run,
        help="print versions, machine, threads, and where data are found",
        examples=("vtbench env", "vtbench env --json > env.json"),
    )
    add_json(parser)


def run(args: Namespace) -> int:
    """Print the environment."""
    from vtbench.environment import describe

    found = describe()
    if args.json:
        print_json(found)
        return 0
    print_table((), _rows(found))
    return 0


def _rows(found: dict[str, Any]) -> list[tuple[str, str]]:
    machine = found["machine"]
    memory = f", {machine['memory_gib']} GiB" if machine["memory_gib"] else ""
    rows = [
        ("vtbench", f"{found['version']} {found['commit']}"),
        ("python", found["python"]),
        ("system", f"{machine['system']} {machine['release']} {machine['architecture']}"),
        ("processor", f"{machine['processor']}, {machine['cores']} cores{memory}"),
        ("fingerprint", found["fingerprint"]),
        ("threads", ", ".join(f"{name}={value}" for name, value in found["threads"].items()) or "not limited"),
        ("cuda", ", ".join(found["cuda"]) or "none: `--device cuda` is refused"),
        ("configs", found["configs"]),
        ("cache", found["cache"]),
        ("VTBENCH_DATA", found["vtbench_data"] or "not set"),
    ]
    rows += [(name, each["path"] or f"not here: `{each['fetch']}`") for name, each in found["recordings"].items()]
    rows.append(("packages", ", ".join(f"{name} {version}" for name, version in found["packages"].items())))
    return rows
