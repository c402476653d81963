"""`vtbench generate`: a scene becomes a dataset."""

from __future__ import annotations

import time
from argparse import Namespace, _SubParsersAction
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from vtbench.commands.output import count_text, print_json, size_text
from vtbench.commands.parser import (
    Parser,
    add_command,
    add_jobs,
    add_json,
    add_out,
    add_scheduler,
    some_of,
    whole_number,
)

TRUTH = ("displacement", "pressure", "contact")


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "generate",
        run,
        help="simulate the recordings of a scene into a dataset",
        about="The bytes depend on scene, seed and version, not on --jobs. Killed half-way, the same command goes on "
        "from the\nlast whole shard; a finished dataset is left as it is.",
        examples=(
            "vtbench generate fvsight-press -o data/paper --samples 324 --jobs 2",
            "vtbench generate fvsight-press/hard -o data/hard --truth pressure,contact",
            "vtbench generate fvsight-slip -o data/slip --jobs 2",
            "vtbench generate my-scene.yaml -o data/mine --seed 1",
            "vtbench generate fvsight-press -o data/full --scheduler tcp://127.0.0.1:8786",
        ),
        resume="the same command goes on from the last whole shard",
    )
    parser.add_argument("scene", metavar="SCENE", help="name (`vtbench list scenes`) or a YAML file of your own")
    add_out(parser, "DIR", "folder of the dataset")
    parser.add_argument("--samples", metavar="N", type=whole_number(1), help="how many (default: the full protocol)")
    parser.add_argument("--seed", metavar="S", type=whole_number(0), default=0, help="run seed (default 0)")
    parser.add_argument("--variation", metavar="V", help="variation of the scene, as in SCENE/V")
    parser.add_argument(
        "--truth",
        metavar="FIELDS",
        type=some_of("field", TRUTH),
        default=(),
        help=f"also keep some of {','.join(TRUTH)}",
    )
    parser.add_argument("--video", action="store_true", help="of slides: keep the camera's frames too")
    parser.add_argument("--fresh", action="store_true", help="start over instead of going on")
    add_jobs(parser)
    add_scheduler(parser)
    add_json(parser)


def run(args: Namespace) -> int:
    """Simulate and write; print what the dataset holds."""
    from vtbench.config import load_scene
    from vtbench.data.opening import write_scene
    from vtbench.scheduling import connect

    name = f"{args.scene}/{args.variation}" if args.variation else args.scene
    scene = load_scene(name)
    started = time.perf_counter()
    with connect(args.scheduler) as cluster, _naming_file(name, scene.id):
        path = write_scene(
            args.out,
            scene,
            samples=args.samples,
            seed=args.seed,
            jobs=args.jobs,
            cluster=cluster,
            truth=args.truth,
            frames=args.video,
            resume=not args.fresh,
        )
    return report(path, time.perf_counter() - started, args.json)


@contextmanager
def _naming_file(name: str, scene_id: str) -> Iterator[None]:
    """The scene's file before what its samples complain of."""
    from vtbench.data.shards import SampleError

    try:
        yield
    except SampleError as error:
        raise error if name == scene_id else ValueError(f"{name}: {error}") from None


def report(path: Path, seconds: float, as_json: bool) -> int:
    """Print what a dataset just written holds."""
    from vtbench.data.opening import open_dataset

    dataset = open_dataset(path)
    size = sum(shard.bytes for shard in dataset.meta.shards)
    if as_json:
        shards = len(dataset.meta.shards)
        print_json({"path": path, **dataset.summary(), "shards": shards, "bytes": size, "seconds": round(seconds, 3)})
        return 0
    files = count_text(len(dataset.meta.shards), "shard")
    print(
        f"{path}: {count_text(dataset.n, 'sample')} of {dataset.meta.name} in {files}, {size_text(size)}, "
        f"{seconds:.1f} s, hash {dataset.hash[:12]}"
    )
    return 0
