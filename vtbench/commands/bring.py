"""`vtbench import` and `vtbench fetch`: recordings that were made elsewhere."""

from __future__ import annotations

import sys
import time
from argparse import Namespace, _SubParsersAction
from pathlib import Path
from typing import TYPE_CHECKING

from vtbench.commands.generate import report
from vtbench.commands.output import count_text, print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, add_out

if TYPE_CHECKING:
    from vtbench.data.mapping import Mapping

BAD_INPUT = 2

_CSV = """\
The folder holds the images and one CSV with a heading and a line for each press:
  file, object, f1, f2, ..., fN                       image, name of the object, taxel forces in newtons
  press, unit, session, rest_file, total_force_n      optional: deep or shallow, sensor, session, image
                                                      before contact, total normal force in newtons
Any other layout (several CSV or NPY, other columns, units or marks, labels in paths) takes a mapping file:
--suggest-mapping prints a first one, --dry-run says what it finds and every problem, and writes nothing."""


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare both commands."""
    parser = add_command(
        commands,
        "import",
        run_import,
        help="turn a folder of images and a CSV of forces into a dataset",
        about=_CSV,
        examples=(
            "vtbench import recordings -o data/mine",
            "vtbench import recordings --suggest-mapping > mapping.yaml",
            "vtbench import recordings --mapping mapping.yaml --dry-run",
            "vtbench import recordings --mapping mapping.yaml -o data/mine",
        ),
        resume="the same command goes on from the last whole shard",
    )
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="the images and the CSV")
    add_out(parser, "DIR", "folder of the dataset", required=False)
    parser.add_argument("--forces", metavar="FILE", help="the CSV (default forces.csv)")
    parser.add_argument("--mapping", metavar="YAML", type=Path, help="how a folder of another layout is read")
    parser.add_argument("--dry-run", action="store_true", help="say what the mapping finds; write nothing")
    parser.add_argument("--suggest-mapping", action="store_true", help="print a first mapping for the folder")
    parser.add_argument("--name", help="name of the dataset (default: the folder's)")
    parser.add_argument("--fresh", action="store_true", help="start over instead of going on")
    add_json(parser)

    parser = add_command(
        commands,
        "fetch",
        run_fetch,
        help="download public recordings, pinned and checked",
        about="They go to the cache (`vtbench env` shows it; VTBENCH_CACHE moves it). Recordings that you have\n"
        "already are found when VTBENCH_DATA is set to the folder that holds NAME/.",
        examples=("vtbench fetch fabricslide16",),
        resume="files that came are kept, the same command brings the others",
    )
    parser.add_argument("name", metavar="NAME", help="one of `vtbench list recordings`")
    add_json(parser)


def run_import(args: Namespace) -> int:
    """Import; print what the dataset holds."""
    from vtbench.data import import_folder

    if args.mapping and args.forces:
        raise ValueError("--forces and --mapping: the mapping names the forces itself; leave one of the two")
    if args.suggest_mapping:
        return _suggest(args)
    mapping = None
    if args.mapping:
        from vtbench.data.mapping import load_mapping

        mapping = load_mapping(args.mapping)
    if args.dry_run:
        return _dry_run(args, mapping)
    if args.out is None:
        raise ValueError("-o: name the folder of the dataset (or --dry-run, --suggest-mapping)")
    started = time.perf_counter()
    forces = args.forces or "forces.csv"
    path = import_folder(args.folder, args.out, forces=forces, mapping=mapping, name=args.name, resume=not args.fresh)
    return report(path, time.perf_counter() - started, args.json)


def _suggest(args: Namespace) -> int:
    from vtbench.data.mapping_suggestion import suggest

    text = suggest(args.folder)
    if args.json:
        print_json({"mapping": text})
        return 0
    print(text, end="")
    return 0


def _dry_run(args: Namespace, mapping: Mapping | None) -> int:
    """Print what would be imported; exit code 2 when something is wrong."""
    from vtbench.data.import_report import dry_run, plain_mapping

    found = dry_run(args.folder, mapping or plain_mapping(args.folder, args.forces or "forces.csv"))
    for problem in found.problems:
        print(f"vtbench: error: {problem}", file=sys.stderr)
    if args.json:
        print_json({"ok": not found.problems, **found.counts, "rows": found.rows, "problems": found.problems})
        return BAD_INPUT if found.problems else 0
    print_table((), [[name.replace("_", " "), _words(value)] for name, value in found.counts.items()])
    if found.rows:
        print()
        print_table(list(found.rows[0]), [list(row.values()) for row in found.rows])
    problems = count_text(len(found.problems), "problem")
    print(f"\n{problems}; nothing was written" if found.problems else "\nno problems; nothing was written")
    return BAD_INPUT if found.problems else 0


def _words(value: object) -> object:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_words(inner)}" for key, inner in value.items()) or "none"
    if isinstance(value, list):
        return " to ".join(map(str, value)) if isinstance(value[0], float) else "x".join(map(str, value))
    return ("yes" if value else "no") if isinstance(value, bool) else value


def run_fetch(args: Namespace) -> int:
    """Fetch; print where the recordings are."""
    from vtbench.data import fetch, public_set

    source = public_set(args.name)
    path = fetch(args.name)
    if args.json:
        print_json({"name": source.name, "path": path, "files": len(source.files), "licence": source.licence})
        return 0
    print(f"{path}: {count_text(len(source.files), 'file')} of {source.name}, checked ({source.licence})")
    print(f"cite: {source.citation}")
    return 0
