"""`vtbench import` and `vtbench fetch`: recordings that were made elsewhere."""

from __future__ import annotations

import time
from argparse import Namespace, _SubParsersAction
from pathlib import Path

from vtbench.commands.generate import report
from vtbench.commands.output import count_text, print_json
from vtbench.commands.parser import Parser, add_command, add_json, add_out

_CSV = """\
The folder holds the images and one CSV with a heading and a line for each press:
  file, object, f1, f2, ..., fN                       image, name of the object, taxel forces in newtons
  press, unit, session, rest_file, total_force_n      optional: deep or shallow, sensor, session, image
                                                      before contact, total normal force in newtons"""


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare both commands."""
    parser = add_command(
        commands,
        "import",
        run_import,
        help="turn a folder of images and a CSV of forces into a dataset",
        about=_CSV,
        examples=("vtbench import recordings -o data/mine", "vtbench import recordings -o data/mine --forces may.csv"),
        resume="the same command goes on from the last whole shard",
    )
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="the images and the CSV")
    add_out(parser, "DIR", "folder of the dataset")
    parser.add_argument("--forces", metavar="FILE", default="forces.csv", help="the CSV (default forces.csv)")
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

    started = time.perf_counter()
    path = import_folder(args.folder, args.out, forces=args.forces, name=args.name, resume=not args.fresh)
    return report(path, time.perf_counter() - started, args.json)


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
