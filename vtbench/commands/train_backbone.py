"""`vtbench train-backbone`: make `vt-vgg` anew, from presses of shapes that no task asks about."""

from __future__ import annotations

import argparse
from argparse import Namespace, _SubParsersAction
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from vtbench.commands.output import print_json, print_table, size_text
from vtbench.commands.parser import Parser, add_command, add_jobs, add_json, add_out, folder, one_of, whole_number

if TYPE_CHECKING:
    from vtbench.training.recipe import Trained

_DEFAULT_IMAGES, _DEFAULT_EPOCHS = 9000, 20


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "train-backbone",
        run,
        help="train the backbone vt-vgg on simulated presses of shapes that no task asks about",
        about="Presses are simulated once and kept; the epoch is chosen on validation shapes and units, the household\n"
        "objects are never read. Prints how well unseen shapes are told apart on unseen units, beside other backbones.",
        examples=(
            "vtbench train-backbone -o vt_vgg.onnx --jobs 2",
            "vtbench train-backbone -o small.onnx --images 600 --epochs 3",
            "vtbench train-backbone -o vt_vgg.onnx --compare --sheet shapes.png",
        ),
        resume="the same command goes on with the presses that are missing; training starts again",
    )
    add_out(parser, "FILE.onnx", "model to write", _model_file)
    parser.add_argument("--seed", metavar="S", type=whole_number(0), default=0, help="run seed (default 0)")
    parser.add_argument(
        "--images",
        metavar="N",
        type=whole_number(64),
        default=_DEFAULT_IMAGES,
        help=f"training presses, each fed as frame and as change (default {_DEFAULT_IMAGES})",
    )
    parser.add_argument(
        "--epochs", metavar="E", type=whole_number(1), default=_DEFAULT_EPOCHS, help=f"default {_DEFAULT_EPOCHS}"
    )
    parser.add_argument("--device", type=one_of("device", ("cpu", "cuda")), default="cpu", help="cpu (default) or cuda")
    parser.add_argument("--threads", metavar="T", type=whole_number(1), default=1, help="of training (default 1)")
    parser.add_argument("--data", metavar="DIR", type=folder, help="where presses are kept (default: vtbench's cache)")
    parser.add_argument("--compare", action="store_true", help="train the other objectives too, and print their rows")
    parser.add_argument("--sheet", metavar="FILE.png", type=Path, help="draw a contact sheet of the training shapes")
    add_jobs(parser)
    add_json(parser)


def run(args: Namespace) -> int:
    """Simulate, train, choose, write and print the evidence."""
    from vtbench.paths import cache_dir
    from vtbench.training.recipe import Settings, train_backbone

    settings = Settings(args.seed, args.images, args.epochs, args.device, args.threads, args.jobs)
    trained = train_backbone(args.out, settings, args.data or cache_dir() / "training", compare=args.compare)
    if args.sheet is not None:
        from vtbench.training.sheet import draw_sheet

        draw_sheet(args.sheet)
    if args.json:
        print_json({**asdict(trained), "path": str(args.out)})
        return 0
    _print(trained, args.out)
    return 0


def _print(trained: Trained, path: Path) -> None:
    columns = ["features", "change, same pose", "frame, same pose", "change, any pose", "frame, any pose", "mean"]
    print("Accuracy in % on held-out units, shapes that were not trained on (in pairs of twins), 3 nearest neighbours:")
    print_table(columns, [[name, *(100 * value for value in row)] for name, row in trained.evidence])
    print(
        f"{path}: {size_text(trained.size_bytes)}, epoch {trained.best_epoch + 1} of {trained.epochs}; "
        f"presses {trained.data_sha256[:12]}; trained in {trained.seconds:.0f} s"
    )
    print(f"use it: `backbone: {path}` in a suite (from the suite's folder), or `vtbench export --backbone {path}`")


def _model_file(text: str) -> Path:
    path = Path(text)
    if path.suffix != ".onnx":
        raise argparse.ArgumentTypeError(f"expected a file that ends in .onnx, got {text!r}")
    return path
