"""`vtbench export` of a slip task: detectors with their thresholds, as graphs of whole sequences or of one sample."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

from vtbench.commands.output import size_text

COLUMNS = (
    "threshold",
    "detector",
    "graph",
    "trials",
    "samples",
    "ties",
    "agreement",
    "largest difference",
    "us a sample",
    "size",
)


@dataclass(frozen=True)
class Graph:
    """A file to be: who and what, in words; what the report of one made before would say; what makes it."""

    modality: str
    method: str
    target: Path
    asked: Mapping[str, Any]
    make: Callable[[], dict[str, Any]]


def graphs_of(args: Namespace) -> list[Graph]:
    """The detector that is asked for, or all.

    Raises:
        ValueError: no trials, or an option that is for presses.
    """
    from vtbench.exporting.detectors import DetectorOrder, export_detector, open_trials, wanted
    from vtbench.run.detection.methods import DETECTORS

    for option in ("scene", "samples", "backbone", "features"):
        if getattr(args, option) is not None:
            raise ValueError(f"{args.task} takes no --{option}; leave it out")
    trials = open_trials(args.task, args.data)
    kind: Literal["batch", "stream"] = "stream" if args.stream else "batch"
    graphs = []
    for name in DETECTORS.ids() if args.all else (args.method,):
        rule = args.modality or next(iter(trials.task.modalities))
        order = DetectorOrder(name, rule, args.variant, args.split, args.fit, args.seed, kind)
        target = args.out / f"{rule}-{name}-{kind}.onnx" if args.all else args.out
        make = partial(export_detector, trials, order, target)
        graphs.append(Graph(rule, name, target, wanted(trials, order), make))
    return graphs


def row(report: dict[str, Any]) -> list[object]:
    """A report as a line of the table."""
    parity, threshold = report["parity"], report["threshold"]
    return [
        f"{threshold['rule']} {threshold['alarm_at_or_above']:.4g}",
        report["method"],
        report["kind"],
        parity["trials"],
        parity["samples"],
        parity["ties"],
        f"{parity['agreement']:.3f}",
        f"{parity['largest_difference']:.1e}",
        f"{parity['us_per_sample']:.2g}",
        size_text(report["bytes"]),
    ]
