"""`vtbench export`: a task's fitted pipeline as one ONNX file, checked against the pipeline before it is written."""

from __future__ import annotations

import hashlib
import json
import tempfile
from argparse import ArgumentTypeError, Namespace, _SubParsersAction
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vtbench.commands import export_slip
from vtbench.commands.export_slip import Graph
from vtbench.commands.output import print_json, print_table, size_text
from vtbench.commands.parser import Parser, add_command, add_jobs, add_json, one_of, whole_number

if TYPE_CHECKING:
    from vtbench.exporting import Order, Samples

SCENE = "fvsight-press"
SAMPLES = 324
NOT_EXPORTED = 1
COLUMNS = (
    "modality",
    "method",
    "samples",
    "ties",
    "agreement",
    "largest difference",
    "ms, batch 1",
    "ms, batch 100",
    "size",
)


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "export",
        run,
        help="write a fitted pipeline or slip detector as one ONNX graph, checked on real samples",
        about="Inputs by name: image, image_rest (N, height, width, 3) uint8; force (N, taxels) float32; force_series "
        "(N, T, taxels).\nOutput: scores (N, classes) float32; of a slip task slip_score (N, T). Only standard "
        "operators. Choices and fit are\nthose of a run on the first fold of the split. The file is written only "
        "where its labels agree with the pipeline's on\nevery sample of the test part, ties excepted; otherwise the "
        "exit code is 1. The report stands in the file's metadata\ntoo, of a slip detector with its threshold. "
        "--stream writes a slip detector as a graph of one sample: force\n(1, taxels) and state_* -> slip_score "
        "(1, 1) and state_*_out, states of zeros at the start.",
        examples=(
            "vtbench export objects/deep/v1 jksc --modality fused --data data/paper -o jksc.onnx",
            "vtbench export objects/deep/v1 svm --modality image-change -o svm.onnx",
            "vtbench export texture/fabricslide16/v1 ipca-wknn -o fabric.onnx",
            "vtbench export objects/deep/v1 --all --data data/paper -o exported",
            "vtbench export slip/fvsight/v1 covariance --stream --data data/slip -o covariance.onnx",
        ),
        resume="with --all the same command goes on with the files that are missing",
    )
    parser.add_argument("task", metavar="TASK", help="task id (`vtbench list tasks`)")
    parser.add_argument(
        "method", metavar="METHOD", nargs="?", help="method or detector id (`vtbench list`), or module:Class"
    )
    parser.add_argument(
        "--all",
        action="store_true",
        help="every method and modality of the task into a folder (nets where --modality names a feed of pixels); "
        "files made before by the same order are kept",
    )
    parser.add_argument("--fresh", action="store_true", help="with --all: make every file again")
    parser.add_argument("--stream", action="store_true", help="a slip detector as a graph of one sample with states")
    parser.add_argument(
        "--modality", metavar="M", help="what it is fed, of a slip task the rule of its threshold (default: the first)"
    )
    parser.add_argument("--variant", metavar="V", help="protocol (default: the task's first)")
    parser.add_argument("--split", metavar="S", help="split of the variant (default: its first)")
    parser.add_argument(
        "--fit",
        type=one_of("part", ("train", "all")),
        default="train",
        help="train (default): the training part of the split's first fold; all: every sample",
    )
    parser.add_argument("--data", metavar="DIR", type=Path, help="folder of a dataset")
    parser.add_argument("--scene", metavar="SCENE", help=f"simulate this scene of presses instead (default {SCENE})")
    parser.add_argument("--samples", metavar="N", type=whole_number(1), help=f"of the scene (default {SAMPLES})")
    parser.add_argument("--seed", metavar="S", type=whole_number(0), default=0, help="of scene and split (default 0)")
    parser.add_argument("--backbone", metavar="B", help="what turns frames into features: a name, or an ONNX file")
    parser.add_argument("--features", metavar="DIR", type=Path, help="keep features of frames here (default: not)")
    parser.add_argument("-o", "--out", metavar="FILE", type=_target, required=True, help="file, or folder with --all")
    add_jobs(parser)
    add_json(parser)


def run(args: Namespace) -> int:
    """Export one graph, or all; print the report."""
    if args.all == bool(args.method):
        raise ValueError("expected a METHOD, or --all for every one; `vtbench list methods` names them")
    if args.fresh and not args.all:
        raise ValueError("--fresh: a single file is always made again; leave it out")
    if args.data is not None and (args.scene is not None or args.samples is not None):
        raise ValueError("expected --data, or --scene with --samples, not both")
    if not args.all and args.out.suffix != ".onnx":
        raise ValueError(f"-o: expected a file that ends in .onnx, got {str(args.out)!r}")
    if not args.all and not args.out.parent.is_dir():
        raise ValueError(f"-o: no folder {args.out.parent}; make it first")
    of_slip = _check_names(args)
    with tempfile.TemporaryDirectory() as kept:
        graphs = export_slip.graphs_of(args) if of_slip else _graphs(args, _samples(args, Path(kept)))
        reports, problems, before = _export(graphs, args)
    if args.json:
        print_json({"exported": reports, "not_exported": problems, "kept": before})
        return NOT_EXPORTED if problems else 0
    if reports and of_slip:
        print_table(export_slip.COLUMNS, [export_slip.row(report) for report in reports])
    elif reports:
        print_table(COLUMNS, [_row(report) for report in reports])
    for problem in problems:
        print(f"not exported: {problem['modality']}, {problem['method']}: {problem['reason']}")
    if before:
        print(f"{before} of {len(graphs)} were made before and are kept; --fresh makes them again")
    return NOT_EXPORTED if problems else 0


def _check_names(args: Namespace) -> bool:
    """Refuse a misspelt word before anything is simulated or read; returns whether the task is one of slip."""
    from vtbench.exporting.fit import method_of
    from vtbench.registry import unknown
    from vtbench.run.detection.methods import DETECTORS
    from vtbench.run.suite import opened_backbone
    from vtbench.tasks import TASKS

    task = TASKS.get(args.task)
    of_slip = task.reads == "slides"
    if args.method:
        if of_slip:
            DETECTORS.get(args.method)
        else:
            method_of(args.method)
    if args.stream and not of_slip:
        raise ValueError(f"--stream: {task.id} has no detector that takes one sample at a time; leave it out")
    for kind, name, known in (
        (f"modality of {task.id}", args.modality, task.modalities),
        (f"variant of {task.id}", args.variant, task.variants),
    ):
        if name is not None and name not in known:
            raise unknown(kind, name, known)
    if args.backbone is not None:
        opened_backbone(args.backbone)
    return of_slip


def _export(graphs: Sequence[Graph], args: Namespace) -> tuple[list[dict[str, Any]], list[dict[str, str]], int]:
    """Reports, problems, and how many files had been made before; with --all one that fails costs no other."""
    from vtbench.data.files import make_folder
    from vtbench.exporting.write import NotExactError, made_before
    from vtbench.run.progress import bar

    if args.all:
        make_folder(args.out)
    reports, problems, before = [], [], 0
    with bar(len(graphs), "graphs", True) as advance:
        for graph in graphs:
            found = made_before(graph.target, graph.asked) if args.all and not args.fresh else None
            try:
                reports.append(found or graph.make())
                before += found is not None
            except OSError:
                raise
            except Exception as error:
                expected = isinstance(error, NotExactError | ValueError)
                if not args.all and not isinstance(error, NotExactError):
                    raise
                reason = str(error) if expected else f"{type(error).__name__}: {error}"
                problems.append({"modality": graph.modality, "method": graph.method, "reason": reason})
            advance(1)
    return reports, problems, before


def _graphs(args: Namespace, samples: Samples) -> list[Graph]:
    """The files that are asked for, as `_orders` has them."""
    from vtbench.exporting import export
    from vtbench.exporting.write import wanted

    graphs = []
    for order in _orders(args, samples):
        target = args.out / f"{order.modality}-{order.method}.onnx" if args.all else args.out
        make = partial(export, samples, order, target)
        graphs.append(Graph(str(order.modality), order.method, target, wanted(samples, order), make))
    return graphs


def _orders(args: Namespace, samples: Samples) -> list[Order]:
    """What is asked for; with --all every feed of the task that is run by default, with every method that takes it."""
    from vtbench.exporting import Order
    from vtbench.run.methods import METHODS

    task = samples.task
    named = {"variant": args.variant, "split": args.split, "fit": args.fit, "seed": args.seed}
    if not args.all:
        return [Order(args.method, args.modality or next(iter(task.modalities)), **named)]
    feeds = {
        name: feed
        for name, feed in task.modalities.items()
        if name == args.modality or (args.modality is None and not feed.by_name)
    }
    return [
        Order(method_id, name, **named)
        for name, feed in feeds.items()
        for method_id, method in METHODS.items()
        if method.takes(feed)
    ]


def _samples(args: Namespace, kept: Path) -> Samples:
    from vtbench.exporting import open_samples
    from vtbench.run.features import DiskFeatures
    from vtbench.run.suite import DEFAULT_BACKBONE
    from vtbench.tasks import TASKS

    path = args.data
    if path is None and TASKS.get(args.task).reads == "presses":
        path = _simulated(args)
    elif args.scene is not None or args.samples is not None:
        raise ValueError(f"{args.task} takes no --scene and no --samples; leave them out")
    cache = DiskFeatures(args.features or kept, args.jobs, progress=True)
    return open_samples(args.task, path, args.backbone or DEFAULT_BACKBONE, cache)


def _simulated(args: Namespace) -> Path:
    """Folder of the simulated scene in the cache, under what decides its bytes; simulated once."""
    from vtbench.config import load_scene
    from vtbench.data.opening import write_scene
    from vtbench.environment import version
    from vtbench.paths import cache_dir

    scene = load_scene(args.scene or SCENE)
    samples = args.samples or SAMPLES
    plan = json.dumps([scene.model_dump(mode="json"), samples, args.seed, version()], sort_keys=True)
    name = f"{scene.id.replace('/', '-')}-{samples}-{hashlib.sha256(plan.encode()).hexdigest()[:12]}"
    return write_scene(cache_dir() / "datasets" / name, scene, samples=samples, seed=args.seed, jobs=args.jobs)


def _row(report: dict[str, Any]) -> list[object]:
    parity = report["parity"]
    return [
        report["modality"],
        report["method"],
        parity["samples"],
        parity["ties"],
        f"{parity['agreement']:.3f}",
        f"{parity['largest_difference']:.1e}",
        round(parity["latency_1_ms"], 2),
        round(parity["latency_100_ms"], 1),
        size_text(report["bytes"]),
    ]


def _target(text: str) -> Path:
    """An argument type: where to write; an empty word is a variable that is not set."""
    if not text.strip():
        raise ArgumentTypeError(f"expected a file, got {text!r}")
    return Path(text)
