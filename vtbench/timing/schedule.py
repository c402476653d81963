"""Processes one at a time, subjects interleaved in another order each round, every sample kept on disk."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vtbench.data.files import make_folder, write_text
from vtbench.environment import THREAD_VARIABLES
from vtbench.run.progress import bar
from vtbench.timing.subject import Subject

Sample = dict[str, Any]
TIMEOUT_S = 600.0


def order(n: int, rounds: int, seed: int = 0) -> Iterator[tuple[int, int]]:
    """(round, subject) pairs: every subject once a round, shuffled anew, so that drift falls on all alike."""
    for number in range(rounds):
        for subject in np.random.default_rng([seed, number]).permutation(n).tolist():
            yield number, subject


def collect(
    subjects: Sequence[Subject], out: Path, folder: Path, rounds: int, progress: bool = True
) -> dict[str, list[Sample]]:
    """Samples of every subject by slug, a list with one entry a process; what `folder` holds is not timed again.

    Args:
        out: folder of the run.
        folder: of this machine's samples, one file a process.

    Raises:
        ValueError: a process failed; its last words.
    """
    make_folder(folder)
    samples: dict[str, list[Sample]] = {subject.slug: [] for subject in subjects}
    steps = list(order(len(subjects), rounds))
    with bar(len(steps), "processes", progress) as advance:
        for number, at in steps:
            subject = subjects[at]
            path = folder / subject.slug / f"{number:03d}.json"
            samples[subject.slug].append(_kept(path) or _timed(subject, out, path, count=number == 0))
            advance(1)
    return samples


def _kept(path: Path) -> Sample | None:
    try:
        found: Sample = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, json.JSONDecodeError):
        return None
    return found


def _timed(subject: Subject, out: Path, path: Path, count: bool) -> Sample:
    asked = {"out": str(out), "key": subject.key, "kind": subject.kind, "block": subject.block, "count": count}
    environment = {**os.environ, **dict.fromkeys(THREAD_VARIABLES, "1")}
    command = [sys.executable, "-m", "vtbench.timing.child"]
    told = json.dumps(asked)
    try:
        done = subprocess.run(
            command, input=told, env=environment, capture_output=True, text=True, timeout=TIMEOUT_S, check=False
        )
    except subprocess.TimeoutExpired:
        raise ValueError(f"{subject.name}: its timing took longer than {TIMEOUT_S:g} s") from None
    if done.returncode != 0:
        words = done.stderr.strip().splitlines()
        raise ValueError(f"{subject.name}: its timing failed: {words[-1] if words else f'exit {done.returncode}'}")
    sample: Sample = json.loads(done.stdout.splitlines()[-1])
    make_folder(path.parent)
    write_text(path, json.dumps(sample) + "\n")
    return sample
