"""`vtbench backbones`: what a frame costs through each backbone, and what a run scored through it."""

from __future__ import annotations

import sys
from argparse import Namespace, _SubParsersAction
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from vtbench.commands.output import print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, picture, whole_number

if TYPE_CHECKING:
    from vtbench.backbones.cost import FrameCost
    from vtbench.backbones.scores import Difference, Score
    from vtbench.run.suite import Suite

OURS, REFERENCE = "vt-vgg", "efficientnet-lite0"
_SCORE_HEADS = ("task", "variant", "split", "fed with", "method", "backbone", "%", "interval", "µs")
_GAP_HEADS = ("task", "variant", "split", "fed with", "method", "difference", "95 % interval", "groups", "by")


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "backbones",
        run,
        help="compare backbones: CPU time of a frame, and the scores of a run",
        about="Times 256x256 frames through ONNX Runtime on one thread, all backbones in turn; vgg16 with random\n"
        "weights, whose speed is that of the published ones. With the folder of a run, prints its scores by backbone\n"
        f"and {OURS} (and each file of one's own) minus {REFERENCE}, paired over groups.",
        examples=(
            "vtbench backbones",
            "vtbench run backbones -o out/backbones --jobs 2",
            "vtbench backbones out/backbones --plot error-against-speed.png",
        ),
    )
    parser.add_argument("run_dir", metavar="DIR", type=Path, nargs="?", help="folder of a run with several backbones")
    parser.add_argument(
        "--frames", metavar="N", type=whole_number(1), default=20, help="frames that are timed (default 20)"
    )
    parser.add_argument("--plot", metavar="FILE.png", type=picture, help="draw error against speed of the run")
    add_json(parser)


def run(args: Namespace) -> int:
    """Time, read the run, print."""
    from fusion.features import backbone_names
    from vtbench.backbones.cost import frame_costs

    if args.plot is not None and args.run_dir is None:
        raise ValueError("--plot: expected the folder of a run too, whose scores are drawn")
    found, gaps, own = _of_run(args.run_dir) if args.run_dir is not None else ([], [], [])
    costs = frame_costs([*backbone_names(), *own], args.frames)
    if args.plot is not None:
        from vtbench.backbones.plot import draw_error_against_speed

        draw_error_against_speed(args.plot, found, {cost.backbone: cost.ms_p50 for cost in costs})
    if args.json:
        from vtbench.environment import fingerprint, machine

        parts = {
            "costs": [asdict(cost) for cost in costs],
            "scores": [asdict(score) for score in found],
            "differences": [asdict(gap) for gap in gaps],
        }
        print_json({"machine": machine(), "fingerprint": fingerprint(), "threads": 1, **parts})
        return 0
    _print(costs, found, gaps)
    return 0


def _of_run(folder: Path) -> tuple[list[Score], list[Difference], list[str]]:
    """Scores and differences of a run, and the files of one's own that it used, where they still are what they were."""
    from fusion.features import backbone_names
    from leaderboard.record import scan_records
    from vtbench.backbones.scores import differences, scores
    from vtbench.run.folder import read_suite
    from vtbench.run.tallies import run_tallies

    suite = read_suite(folder)
    records, problems = scan_records(folder)
    found = scores(records)
    if not found:
        raise ValueError(f"{folder}: expected scores of image or image-change alone, found none")
    kept = {score.key for score in found}
    tallies, without = run_tallies(folder, [record for record in records if record.key in kept])
    mine = sorted({score.backbone for score in found} - set(backbone_names()))
    own = _own_files(suite)
    lost = [f"{name}: its file is gone or another one now, so it is not timed" for name in mine if name not in own]
    for problem in (*problems, *without, *lost):
        print(f"vtbench: warning: {problem}", file=sys.stderr)
    gaps = [gap for first in (OURS, *mine) for gap in differences(found, tallies, first, REFERENCE)]
    return found, gaps, [own[name] for name in mine if name in own]


def _own_files(suite: Suite) -> dict[str, str]:
    """Paths of the suite's own backbones that can still be opened, by the name in their records."""
    from fusion.features import get_backbone, is_own_file

    found = {}
    for path in {suite.backbone, *(entry.backbone for entry in suite.entries)}:
        if path is not None and is_own_file(path):
            with suppress(ValueError, OSError):
                found[get_backbone(path).name] = path
    return found


def _print(costs: list[FrameCost], found: list[Score], gaps: list[Difference]) -> None:
    print("A 256x256 frame through each backbone: CPU milliseconds, one thread, ONNX Runtime, in turn\n")
    heads = ["backbone", "features", "graph MB", "licence", "ms min", "ms p50", "ms p95", "times vgg16"]
    rows = [
        [c.backbone, c.features, c.model_mb, c.licence, c.ms_min, c.ms_p50, c.ms_p95, c.times_faster_than_vgg16]
        for c in costs
    ]
    print_table(heads, rows)
    print("vgg16: random weights, for its speed; its accuracy is not measured where its weights cannot be had")
    if found:
        print("\nAccuracy in % and its 95 % interval; microseconds a sample of the classifier with its PCA\n")
        print_table(_SCORE_HEADS, _score_rows(found))
    for first in dict.fromkeys(gap.first for gap in gaps):
        print(f"\n{first} minus {REFERENCE}, percentage points, paired over groups\n")
        print_table(_GAP_HEADS, [_gap_row(gap) for gap in gaps if gap.first == first])


def _score_rows(found: list[Score]) -> list[list[object]]:
    """One row a score, and one a protocol for vgg16 where the run holds none of it."""
    rows: list[list[object]] = [
        [*s.protocol, s.method, s.backbone, f"{100 * s.value:.1f}", _interval(s.low, s.high), _whole(s.predict_us)]
        for s in found
    ]
    if not any(s.backbone == "vgg16" for s in found):
        protocols = dict.fromkeys(s.protocol for s in found)
        rows += [[*protocol, "", "vgg16", "not measured", "-", "-"] for protocol in protocols]
    return sorted(rows, key=lambda row: [str(value) for value in row[:6]])


def _gap_row(gap: Difference) -> list[object]:
    between = f"{100 * gap.low:+.1f} to {100 * gap.high:+.1f}"
    where = [gap.task, gap.variant, gap.split, gap.modality, gap.method]
    return [*where, f"{100 * gap.value:+.1f}", between, gap.groups, gap.interval]


def _whole(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"


def _interval(low: float | None, high: float | None) -> str:
    return "-" if low is None or high is None else f"{100 * low:.1f} to {100 * high:.1f}"
