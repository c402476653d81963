"""`vtbench evaluate`: somebody else's model, or a folder that hands models in, scored in a sandbox."""

from __future__ import annotations

import sys
from argparse import ArgumentTypeError, Namespace, _SubParsersAction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vtbench.commands.output import print_json, print_table, size_text
from vtbench.commands.parser import Parser, add_command, add_jobs, add_json, folder, whole_number

if TYPE_CHECKING:
    from leaderboard.record import Record
    from leaderboard.submission import Latency

PARTS_FAILED = 1


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "evaluate",
        run,
        help="score somebody else's ONNX model, or a submission, in a sandbox",
        about="The model runs in a process of its own: limits on time and memory, no network, no file to open or write "
        "where\nthe kernel allows it; the record says what held. Inputs by name: image, image_rest (N, H, W, 3) uint8, "
        "force\n(N, taxels) float32 newtons, force_series (N, T, taxels); output scores (N, classes), of a slip task "
        "slip_score (N, T).\nA model takes those inputs that it wants. A slip graph of one sample (force (1, taxels) "
        "and state_*) is run over whole\ntrials, tens of microseconds a sample. A file of `vtbench export` that is "
        "tested on what it was fitted on is flagged.\nExits with 1 when the model failed or is flagged, with the "
        "reason in its record.",
        examples=(
            "vtbench evaluate net.onnx --task objects/deep/v1 --data out/quick/datasets/paper -o out/theirs",
            "vtbench evaluate net.onnx --task objects/deep/v1 --variant hard --hidden-seed new -o out/theirs",
            "vtbench evaluate net.onnx --task texture/fabricslide16/v1 -o out/theirs",
            "vtbench evaluate my-submission --data out/quick/datasets/paper -o out/theirs",
        ),
        resume="the same command evaluates again",
    )
    parser.add_argument("model", metavar="MODEL", type=Path, help="an .onnx file, or a folder with submission.yaml")
    parser.add_argument("--task", metavar="TASK", help="id of the task; a submission names its own")
    parser.add_argument("--variant", metavar="V", help="protocol of the task (default: its first)")
    parser.add_argument("--split", metavar="S", help="score the test parts of this split (default: every recording)")
    parser.add_argument("--fold", metavar="F", help="score one fold of the split only")
    parser.add_argument(
        "--data", metavar="DIR", type=folder, action="append", default=[], help="dataset; a slip task joins several"
    )
    parser.add_argument(
        "--hidden-seed", metavar="N", type=_seed, help="test on a fresh hidden set; 'new' draws a seed and prints it"
    )
    parser.add_argument("--samples", metavar="N", type=whole_number(1), help="size of the hidden set (default: all)")
    parser.add_argument("--seed", metavar="N", type=whole_number(0), default=0, help="of random splits (default 0)")
    parser.add_argument(
        "--time-limit", metavar="S", type=_seconds, default=300.0, help="seconds for the model (default 300)"
    )
    parser.add_argument(
        "--memory-limit", metavar="MB", type=whole_number(64), default=2048, help="beside runtime and inputs (2048)"
    )
    parser.add_argument("--name", metavar="NAME", help="what tables call the model (default: the file's name)")
    parser.add_argument("-o", "--out", metavar="DIR", type=folder, required=True, help="folder of a run, old or new")
    add_jobs(parser)
    add_json(parser)


def run(args: Namespace) -> int:
    """Evaluate and print one line a result."""
    from vtbench.onnx_eval.sandbox import Limits
    from vtbench.submissions.score import Terms, evaluate_folder, evaluate_model

    if args.samples is not None and args.hidden_seed is None:
        raise ValueError("--samples: it is the size of a hidden set; give --hidden-seed too")
    if args.hidden_seed is not None and args.data:
        raise ValueError("--hidden-seed: a hidden set is made anew, so --data has no place beside it")
    if args.hidden_seed is not None and args.fold is not None:
        raise ValueError("--fold: every recording of a hidden set is tested; leave it out")
    if args.hidden_seed is not None:
        _warn_of_seed(args.hidden_seed)
    terms = Terms(
        variant=args.variant,
        split=args.split,
        fold=args.fold,
        data=tuple(args.data),
        hidden_seed=args.hidden_seed,
        samples=args.samples,
        seed=args.seed,
        jobs=args.jobs,
        limits=Limits(args.time_limit, args.memory_limit),
    )
    if args.model.is_dir():
        for option in ("task", "name"):
            if getattr(args, option) is not None:
                raise ValueError(f"--{option}: {args.model} is a folder, its submission.yaml says that")
        records = evaluate_folder(args.model, terms, args.out)
    else:
        if args.task is None:
            raise ValueError(f"--task: say which task {args.model} solves (`vtbench list tasks`)")
        records = [evaluate_model(args.model, args.task, args.name, terms, args.out)]
    if args.json:
        print_json([record.model_dump(mode="json") for record in records])
    else:
        for record in records:
            _report(record)
        print(f"page: vtbench board {args.out} -o {args.out / 'board'}")
    good = all(record.status.state == "ok" and _status(record) != "flagged" for record in records)
    return 0 if good else PARTS_FAILED


def _report(record: Record) -> None:
    identity, submission = record.identity, record.submission
    where = f"{identity.task} {identity.variant} {identity.split}"
    if record.status.state != "ok":
        print(f"{identity.method}: {record.status.state} on {where}: {record.status.reason}")
    else:
        metric = record.metrics[0]
        low, high = metric.low, metric.high
        span = f" ({100 * low:.1f} to {100 * high:.1f})" if low is not None and high is not None else ""
        groups = f"{metric.n} predictions, {metric.groups} groups"
        print(f"{identity.method}: {metric.name} {100 * metric.value:.1f} %{span}, {where}, {groups}")
    assert submission is not None
    if record.status.state == "ok":
        print(f"  status: {submission.status}{submission.reason and f' ({submission.reason})'}")
    if submission.hidden:
        print(f"  hidden set: commitment {submission.hidden}")
    artifact = submission.artifact
    if artifact is None:
        return
    parts = [size_text(artifact.size_bytes)]
    parts += [f"{artifact.parameters:,} parameters"] if artifact.parameters is not None else []
    parts += [f"{artifact.peak_rss_mb:.0f} MB at most"] if artifact.peak_rss_mb is not None else []
    print(f"  artifact: {', '.join(parts)}, SHA-256 {artifact.sha256[:12]}")
    if artifact.latency:
        calls = [(f"  {each.batch}", *_latency(each), each.calls) for each in artifact.latency]
        print_table(("  batch", "first, ms", "min", "p50", "p95", "calls"), calls)
    lost = [f"{name}: {what}" for name, what in artifact.protections.items() if what != "held"]
    if artifact.protections:
        print(f"  sandbox: {'; '.join(lost) if lost else 'held (' + ', '.join(artifact.protections) + ')'}")


def _latency(latency: Latency) -> list[str]:
    times = (latency.first_ms, latency.min_ms, latency.p50_ms, latency.p95_ms)
    return ["-" if time is None else f"{time:.3g}" for time in times]


def _status(record: Record) -> Any:
    return record.submission.status if record.submission is not None else None


def _warn_of_seed(seed: int) -> None:
    from vtbench.onnx_eval.hidden import GUESSABLE

    if seed < GUESSABLE:
        text = "a seed this small can be found by trying all; --hidden-seed new draws a long one"
    else:
        text = f"keep the hidden seed to yourself: {seed}"
    print(f"vtbench: warning: {text}", file=sys.stderr)


def _seed(text: str) -> int:
    from vtbench.onnx_eval.hidden import parse_seed

    try:
        return parse_seed(text)
    except ValueError as error:
        raise ArgumentTypeError(str(error).removeprefix("--hidden-seed: ")) from None


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1e6:
        raise ArgumentTypeError(f"expected seconds, such as 300, got {text!r}")
    return value
