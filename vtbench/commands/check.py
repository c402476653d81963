"""`vtbench validate`: is a configuration, a dataset or a run what it should be?"""

from __future__ import annotations

import sys
from argparse import Namespace, _SubParsersAction
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vtbench.commands.output import count_text, print_json
from vtbench.commands.parser import Parser, add_command, add_json
from vtbench.registry import hint

if TYPE_CHECKING:
    from vtbench.run.suite import OwnMethod, Suite

BAD_INPUT = 2


@dataclass(frozen=True)
class Verdict:
    """What was found: the kind of thing, its size in words, and every problem in one line each."""

    path: str
    kind: str
    about: str
    problems: list[str]


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "validate",
        run,
        help="check a configuration, a dataset or a run",
        about="Prints every problem in one line and exits with 2 when there is one. Datasets are read whole:\n"
        "checksums, columns, forces, frames. A scene is checked with all its variations, a suite with its scenes.",
        examples=(
            "vtbench validate my-scene.yaml",
            "vtbench validate data/paper",
            "vtbench validate out/quick",
        ),
    )
    parser.add_argument(
        "path", metavar="PATH", nargs="+", help="a YAML file, a folder, or the name of a scene or suite"
    )
    add_json(parser)


def run(args: Namespace) -> int:
    """Check each path; problems go to standard error."""
    verdicts = [verdict for path in args.path for verdict in _check(path)]
    for verdict in verdicts:
        for problem in verdict.problems:
            text = problem if verdict.path in problem else f"{verdict.path}: {problem}"
            print(f"vtbench: error: {text}", file=sys.stderr)
        if not verdict.problems and not args.json:
            print(f"{verdict.path}: ok ({verdict.kind}, {verdict.about})")
    if args.json:
        print_json(
            [
                {"path": v.path, "kind": v.kind, "ok": not v.problems, "about": v.about, "problems": v.problems}
                for v in verdicts
            ]
        )
    return BAD_INPUT if any(verdict.problems for verdict in verdicts) else 0


def _check(name: str) -> list[Verdict]:
    """As `check`; what cannot be checked at all is a problem too, and does not hide the verdicts on the rest."""
    try:
        return check(name)
    except ValueError as error:
        return [Verdict(name, "unknown", "", [str(error)])]


def check(name: str) -> list[Verdict]:
    """Verdicts on what stands at a path, or on the scene or suite of that name.

    Raises:
        ValueError: nothing there that can be checked.
    """
    path = Path(name)
    if not path.exists() or (path.is_dir() and _is_name(name) and not _is_made_here(path)):
        return [_named(name)]
    if path.name == "dataset.json":
        path = path.parent
    if path.is_dir():
        return list(_folder(path))
    if path.suffix in (".yaml", ".yml"):
        return [_config(path)]
    raise ValueError(f"{name}: expected a YAML file, or the folder of a dataset or a run")


def _is_name(name: str) -> bool:
    from vtbench.config import scene_names, suite_names

    return name in (*scene_names(), *suite_names())


def _is_made_here(path: Path) -> bool:
    """Whether a folder holds a dataset or a run, rather than only sharing a suite's name."""
    return any((path / made).exists() for made in ("dataset.json", "dataset.partial.json", "suite.yaml", "runs"))


def _named(name: str) -> Verdict:
    from vtbench.config import scene_names, suite_names

    if name in scene_names():
        return _scene(name)
    if name in suite_names():
        return _suite(name)
    near = hint(name, [*scene_names(), *suite_names()])
    raise ValueError(f"{name}: no such file or folder, nor a scene or suite of that name{near}")


def _folder(path: Path) -> Iterator[Verdict]:
    if (path / "dataset.json").exists() or (path / "dataset.partial.json").exists():
        yield _dataset(path)
    elif (path / "suite.yaml").exists() or (path / "runs").exists():
        yield _run(path)
    elif configs := sorted(path.rglob("*.yaml")):
        yield from map(_config, configs)
    else:
        raise ValueError(f"{path}: expected a dataset (dataset.json), a run (suite.yaml) or YAML files in this folder")


def _dataset(path: Path) -> Verdict:
    from vtbench.data import check_dataset
    from vtbench.data.opening import open_dataset

    problems = check_dataset(path)
    about = "" if problems else f"{count_text(open_dataset(path, verify=False).n, 'sample')}"
    return Verdict(str(path), "dataset", about, problems)


def _run(path: Path) -> Verdict:
    from vtbench.run import check_run

    problems = check_run(path)
    count = len(list(path.glob("runs/*/record.json")))
    kind = "run" if (path / "suite.yaml").exists() else "evaluations"
    return Verdict(str(path), kind, count_text(count, "record"), problems)


def _config(path: Path) -> Verdict:
    """A configuration by the folder that it stands in, else by its keys."""
    from vtbench.yaml_file import read_yaml

    kind = {"scenes": "scene", "suites": "suite"}.get(path.resolve().parent.name, "")
    if not kind:
        try:
            keys = read_yaml(path).data
        except ValueError as error:
            return Verdict(str(path), "configuration", "", [str(error)])
        kind = "suite" if {"entries", "datasets"} & keys.keys() else "scene"
    return _scene(str(path)) if kind == "scene" else _suite(str(path))


def _scene(name: str) -> Verdict:
    from vtbench.config import load_scene, variation_names

    problems = _problems(load_scene, name)
    variations = [] if problems else variation_names(name)
    problems += [problem for variation in variations for problem in _problems(load_scene, f"{name}/{variation}")]
    return Verdict(name, "scene", count_text(len(variations), "variation"), problems)


def _suite(name: str) -> Verdict:
    from vtbench.config import load_suite

    problems = _problems(load_suite, name)
    if problems:
        return Verdict(name, "suite", "", problems)
    suite = load_suite(name)
    return Verdict(name, "suite", count_text(len(suite.entries), "task"), suite_problems(suite))


def suite_problems(suite: Suite) -> list[str]:
    """What would stop a suite after work has begun: a scene that does not load, a classifier that cannot be made."""
    from vtbench.config import load_scene

    problems = []
    for spec in suite.datasets:
        if spec.scene is not None:
            found = _problems(load_scene, spec.scene, spec.set, "set")
            problems += [f"dataset {spec.id}: {problem}" for problem in found]
    for name, own in suite.methods.items():
        problems += [f"method {name}: {problem}" for problem in _problems(_build_once, name, own)]
    return [*problems, *_wrong_feeds(suite)]


def _wrong_feeds(suite: Suite) -> Iterator[str]:
    """Nets that an entry feeds with what has no shape to learn from."""
    from vtbench.run.methods import METHODS
    from vtbench.tasks import TASKS

    for entry in suite.entries:
        task = TASKS.get(entry.task)
        nets = [name for name in entry.methods if name in METHODS and METHODS.get(name).shaped]
        shaped = [name for name, feed in task.modalities.items() if feed.shaped]
        for modality in entry.modalities or (() if nets and shaped else task.modalities):
            if nets and not task.feed(modality).shaped:
                instead = f"use {' or '.join(shaped)}, in an entry of its own" if shaped else "the task has none"
                yield f"method {nets[0]} learns from pixels and force histories, not from {modality!r}; {instead}"


def _build_once(name: str, own: OwnMethod) -> None:
    from vtbench.run.methods.external import check_external, external_method

    check_external(external_method(name, own.estimator, own.params, own.choose))


def _problems(load: Callable[..., object], *arguments: object) -> list[str]:
    try:
        load(*arguments)
    except ValueError as error:
        return [str(error)]
    return []
