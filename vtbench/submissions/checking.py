"""Folders of submissions -> every problem of each; one that is bad leaves the verdict on the others as it is."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from leaderboard.submission import SubmissionEntry, SubmissionFile
from vtbench.data.files import sha256_of
from vtbench.onnx_eval.contract import Contract, Port
from vtbench.onnx_eval.sandbox import LARGEST_MODEL_MB, Job, Limits, private_folder, run
from vtbench.registry import hint
from vtbench.submissions.predictions import read_predictions_file
from vtbench.submissions.reading import artifact_path, read_submission
from vtbench.submissions.rules import Problem
from vtbench.tasks import TASKS
from vtbench.tasks.base import Task
from vtbench.tasks.slides import SlipTask

LOOK = Limits(time_s=60.0, memory_mb=2048)
_INPUTS = {
    "presses": ("image", "image_rest", "force", "force_series"),
    "slides": ("force_series",),
    "fabricslide16": ("force_series",),
    "biotacsp_stability_v2": ("force",),
}
_FRAME = ("N", None, None, 3)
_PORTS = {
    "image": Port("image", "uint8", _FRAME),
    "image_rest": Port("image_rest", "uint8", _FRAME),
    "force": Port("force", "float32", ("N", None)),
    "force_series": Port("force_series", "float32", ("N", None, None)),
}


@dataclass(frozen=True)
class Checked:
    """What a folder hands in, where that is known, and its problems."""

    folder: Path
    file: SubmissionFile | None
    problems: tuple[Problem, ...]

    def of_entry(self, number: int) -> list[Problem]:
        """Problems of one entry."""
        return [problem for problem in self.problems if problem.entry == number]


def check_folders(folders: Sequence[Path], limits: Limits = LOOK) -> list[Checked]:
    """Check each folder by itself, then all of them against each other."""
    found = [check_folder(folder, limits) for folder in folders]
    ids: dict[str, list[int]] = defaultdict(list)
    artifacts: dict[str, set[tuple[str, int]]] = defaultdict(set)
    for at, each in enumerate(found):
        if each.file is None:
            continue
        ids[each.file.id].append(at)
        for entry in each.file.entries:
            path = artifact_path(each.folder, entry)
            if isinstance(path, Path):
                artifacts[sha256_of(path)].add((each.file.id, at))
    more: dict[int, list[Problem]] = defaultdict(list)
    for name, places in ids.items():
        for at in places if len(places) > 1 else ():
            others = ", ".join(str(found[other].folder) for other in places if other != at)
            more[at].append(Problem("S010", f"expected an id of its own, found {name!r} in {others} too", "change it"))
    for owners in artifacts.values():
        names = {name for name, _ in owners}
        for name, at in owners if len(names) > 1 else ():
            text = f"expected a file of its own, found the same bytes handed in by {', '.join(sorted(names - {name}))}"
            more[at].append(Problem("S010", text, "hand it in once"))
    return [Checked(each.folder, each.file, (*each.problems, *more[at])) for at, each in enumerate(found)]


def check_folder(folder: Path, limits: Limits = LOOK) -> Checked:
    """Check one folder; its models are looked into in the sandbox, and not run."""
    file, problems = read_submission(folder)
    if file is None:
        return Checked(folder, None, tuple(problems))
    seen: dict[tuple[str | None, ...], int] = {}
    for number, entry in enumerate(file.entries):
        problems += _entry(folder, number, entry, limits)
        name = (entry.task, entry.variant, entry.split, entry.fold)
        first = seen.setdefault(name, number)
        if first != number:
            found = f"expected one entry for {entry.task}, found entry {first + 1} for the same"
            problems.append(Problem("S011", found, "leave one out, or say another split", number))
    return Checked(folder, file, tuple(problems))


def _entry(folder: Path, number: int, entry: SubmissionEntry, limits: Limits) -> Iterator[Problem]:
    problem = name_problem(entry)
    if problem is not None:
        yield Problem("S005", problem, "`vtbench list tasks` shows them", number)
        return
    path = artifact_path(folder, entry)
    if isinstance(path, str):
        yield Problem("S006", path, "put the file there and name it relative to the folder", number)
        return
    task = TASKS.get(entry.task)
    if entry.predictions is None:
        yield from _model(path, task, limits, number)
    elif not (yield from _size(path, number)):
        try:
            read_predictions_file(path)
        except ValueError as error:
            yield Problem("S009", str(error), "correct the file", number)


def check_model(path: Path, task_id: str, limits: Limits = LOOK) -> Checked:
    """Check one model by itself against the contract of a task; it is looked into in the sandbox, and not run."""
    return Checked(path, None, tuple(_model(path, TASKS.get(task_id), limits, None)))


def _size(path: Path, number: int | None) -> Generator[Problem, None, bool]:
    """A problem for a file that is too large; returns whether it is."""
    size = path.stat().st_size
    if size > LARGEST_MODEL_MB * 2**20:
        found = f"expected {LARGEST_MODEL_MB} MB at most, found {size >> 20} MB"
        yield Problem("S007", found, "store weights in fewer bits, or leave out what is not used", number)
        return True
    return False


def _model(path: Path, task: Task, limits: Limits, number: int | None) -> Iterator[Problem]:
    if (yield from _size(path, number)):
        return
    with private_folder(path.read_bytes()) as place:
        answer = run(place, general_contract(task), Job(), limits)
    if answer.state != "ok":
        yield Problem("S008", answer.reason, "export it again; the docs on submitting tell the contract", number)


def name_problem(entry: SubmissionEntry) -> str | None:
    """What of an entry's task, variant and split there is not, with the closest that there is."""
    if entry.task not in TASKS:
        return f"expected a task, found {entry.task!r}{hint(entry.task, TASKS.ids())}"
    task = TASKS.get(entry.task)
    variant = entry.variant or next(iter(task.variants))
    if variant not in task.variants:
        return f"expected a variant of {task.id}, found {variant!r}{hint(variant, task.variants)}"
    splits = [*task.variants[variant].splits, *([] if isinstance(task, SlipTask) else ["all"])]
    if entry.split is not None and entry.split not in splits:
        return f"expected a split of {task.id}, {variant}, found {entry.split!r}{hint(entry.split, splits)}"
    if entry.predictions is not None and isinstance(task, SlipTask):
        return f"expected a model for {task.id}, found predictions: slip is scored on the scores of whole trials"
    return None


def general_contract(task: Task) -> Contract:
    """The contract of a task before its recordings are known: sizes of frames, arrays and classes are open."""
    scores = (
        Port("slip_score", "float32", ("N", None))
        if isinstance(task, SlipTask)
        else Port("scores", "float32", ("N", None))
    )
    return Contract(tuple(_PORTS[name] for name in _INPUTS[task.reads]), scores)
