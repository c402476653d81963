"""Small presses of four objects in three units, suites on them, and samples in memory, for tests of a run."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.vtbench.data import fakes
from vtbench.data import write_dataset
from vtbench.run.evaluate import Work
from vtbench.run.methods import METHODS
from vtbench.run.methods.external import external_method
from vtbench.run.suite import Suite
from vtbench.tasks.base import Block, Feed, Fold, Split

OWN = "tests.vtbench.run.own_classifiers"
CLASSES = len(fakes.OBJECTS)
N = 48
WIDE = Block("image", components=(2, 4, 8))
NARROW = Block("force")
FUSED = Feed((WIDE, NARROW), weights="chosen")
FORCE = Feed((NARROW,))


def simulate(scene, index, seed, truth=()):
    """A press whose force says which object it is, though not always."""
    made = fakes.simulate(scene, index, seed, truth)
    label = index % CLASSES
    force = np.random.default_rng(label).gamma(2.0, 0.5, 16) + np.random.default_rng([seed, index]).normal(0, 0.8, 16)
    return replace(
        made, force=force.astype(np.float32), labels={**made.labels, "id": f"{index:06d}", "unit": index // 16}
    )


def write(folder, seed=0, samples=N):
    return write_dataset(
        folder, fakes.FakeScene(), samples=samples, seed=seed, simulate=simulate, describe=fakes.describe
    )


def own(name, **params):
    return {"estimator": f"{OWN}:{name}", "params": params}


def suite(data, methods=("knn",), own_methods=None, entry=None, **changes):
    """A suite of the force alone, random draws and held-out units, on the dataset `own`."""
    entry = {
        "task": "objects/interference/v1",
        "variants": ["own"],
        "splits": ["random", "held-out-unit"],
        "modalities": ["force"],
        "methods": list(methods),
        "probes": False,
        **(entry or {}),
    }
    return Suite.model_validate(
        {
            "id": "small",
            "title": "a small one",
            "datasets": [{"id": "own", "path": str(data)}],
            "methods": own_methods or {},
            "entries": [entry],
            **changes,
        }
    )


def states(summary):
    """(method, split) -> state of every record."""
    return {(r.identity.method, r.identity.split): r.status.state for r in summary.records}


def samples(seed=0, n=60, classes=3):
    """Blocks (n, columns), labels and groups in memory; labels are hard to tell, so that choices differ."""
    rng = np.random.default_rng(seed)
    labels = np.arange(n) % classes
    blocks = {
        name: (rng.normal(size=(classes, width))[labels] + spread * rng.normal(size=(n, width))).astype(np.float32)
        for name, width, spread in (("image", 12, 1.5), ("force", 5, 1.0))
    }
    return blocks, labels, np.repeat(np.arange(4), n // 4)


def work(method, feed=FUSED, *, blocks=None, labels=None, folds=None, groups=None, samples_name="s", **changes):
    """One cell's work: the last third of the samples is the test part."""
    made, truth, _ = samples()
    blocks, labels = blocks or made, truth if labels is None else labels
    n = len(labels)
    folds = folds or (Fold("one", np.arange(2 * n // 3), np.arange(2 * n // 3, n)),)
    ids = np.array([f"{i:03d}" for i in range(n)])
    values = {
        "key": method.id,
        "method": method,
        "feed": feed,
        "split": Split("split", folds, ids, "press", groups),
        "samples": samples_name,
        "blocks": blocks,
        "labels": labels,
        "ids": ids,
        "n_classes": 3,
        "seed": 0,
        "timeout_s": 600.0,
    }
    return Work(**{**values, **changes})


def method(name, **params):
    """A registered method, or one of `own_classifiers`."""
    return METHODS.get(name) if name in METHODS else external_method(name.lower(), f"{OWN}:{name}", params, {})


def run_file(path, out, jobs):
    """Run the suite of a JSON file, in a process that may be killed."""
    from vtbench.run import run_suite

    run_suite(Suite.model_validate_json(Path(path).read_text(encoding="utf-8")), out, jobs=jobs, progress=False)
