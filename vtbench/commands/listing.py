"""`vtbench list`: what there is to run, with one line about each."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction
from collections.abc import Callable
from typing import Any

from vtbench.commands.output import print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, one_of

Rows = list[dict[str, Any]]


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "list",
        run,
        help="list scenes, objects, sensors, backbones, methods, detectors, tasks, suites, recordings",
        examples=("vtbench list", "vtbench list scenes", "vtbench list tasks --json"),
    )
    parser.add_argument(
        "what", nargs="?", type=one_of("kind", list(KINDS)), help=f"one of {', '.join(KINDS)}; all of them by default"
    )
    add_json(parser)


def run(args: Namespace) -> int:
    """Print one table for each kind asked for."""
    kinds = [args.what] if args.what else list(KINDS)
    found = {kind: KINDS[kind]() for kind in kinds}
    if args.json:
        print_json(found)
        return 0
    for number, (kind, rows) in enumerate(found.items()):
        if not args.what:
            print(f"{chr(10) if number else ''}{kind.upper()}")
        if rows:
            print_table(list(rows[0]), [list(map(_joined, row.values())) for row in rows])
        else:
            print("none")
    return 0


def _joined(value: Any) -> Any:
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else value


def scenes() -> Rows:
    """Scenes and their variations."""
    from vtbench.config import load_scene, scene_names

    loaded = [load_scene(name) for name in scene_names()]
    return [{"scene": scene.id, "samples": scene.n_samples, "about": scene.title} for scene in loaded]


def objects() -> Rows:
    """Household objects, in the order of their class labels."""
    from sensors import objects as household

    found = map(household.get, household.names())
    return [{"object": thing.name, "family": thing.family, "about": thing.title} for thing in found]


def sensors() -> Rows:
    """Simulated sensors."""
    from sensors.catalogue import SENSORS

    return [{"sensor": name, "gives": one.gives, "about": one.about} for name, one in SENSORS.items()]


def backbones() -> Rows:
    """Networks that turn a frame into features."""
    from fusion.features import backbone_names, get_backbone

    found = map(get_backbone, backbone_names())
    return [{"backbone": each.name, "features": each.dim, "licence": each.licence} for each in found]


def methods() -> Rows:
    """Classifiers."""
    from vtbench.run.methods import METHODS

    return [{"method": name, "about": method.about} for name, method in METHODS.items()]


def detectors() -> Rows:
    """Slip detectors."""
    from vtbench.run.detection.methods import DETECTORS

    return [{"detector": name, "about": detector.about} for name, detector in DETECTORS.items()]


def tasks() -> Rows:
    """Benchmark tasks with their protocols."""
    from vtbench.tasks import TASKS

    return [{"task": name, "variants": list(task.variants), "about": task.about} for name, task in TASKS.items()]


def suites() -> Rows:
    """Suites, ready to run."""
    from vtbench.config import load_suite, suite_names

    return [{"suite": name, "about": load_suite(name).title} for name in suite_names()]


def recordings() -> Rows:
    """Public recordings, and whether they are on this machine."""
    from vtbench.environment import recordings as known

    return [
        {
            "recordings": name,
            "here": each["path"] or f"no: {each['fetch']}",
            "licence": each["licence"],
            "about": each["title"],
        }
        for name, each in known().items()
    ]


KINDS: dict[str, Callable[[], Rows]] = {
    "scenes": scenes,
    "objects": objects,
    "sensors": sensors,
    "backbones": backbones,
    "methods": methods,
    "detectors": detectors,
    "tasks": tasks,
    "suites": suites,
    "recordings": recordings,
}
