"""The recipe of `vt-vgg` from seed to file."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import asdict, astuple, dataclass
from datetime import UTC, datetime
from pathlib import Path

from vtbench.data.files import make_folder, sha256_of
from vtbench.training.evidence import Evidence, evidence
from vtbench.training.presses import (
    RECIPE_VERSION,
    Arrays,
    TrainingPlan,
    ValidationPlan,
    data_sha256,
    training_presses,
    validation_presses,
)

BESIDE = ("pixels", "efficientnet-lite0")
"""Backbones whose features of the validation presses stand beside ours."""


@dataclass(frozen=True)
class Settings:
    """What the command says; `threads` of training, `jobs` processes that simulate."""

    seed: int = 0
    images: int = TrainingPlan.presses
    epochs: int = 20
    device: str = "cpu"
    threads: int = 1
    jobs: int = 1


@dataclass(frozen=True)
class Trained:
    """What was written, and the evidence: (name, (four accuracies and their mean, 0 to 1)) a row, ours first."""

    size_bytes: int
    sha256: str
    data_sha256: str
    best_epoch: int
    epochs: int
    seconds: float
    evidence: tuple[tuple[str, tuple[float, ...]], ...]


def train_backbone(
    path: Path, settings: Settings, data: Path, *, compare: bool = False, progress: bool = True
) -> Trained:
    """Simulate presses below `data`, train, and write the model to `path`.

    `compare` trains the other objectives too, for their rows. ValueError for a device that is not there; OSError where
    a file cannot be written.
    """
    import torch

    from vtbench.training.fit import check_device, fit, reduced_precision
    from vtbench.training.model_file import write_model
    from vtbench.training.network import Objective

    check_device(settings.device)
    make_folder(path.parent)
    commit = _commit()
    torch.set_num_threads(settings.threads)
    plan, check = TrainingPlan(settings.seed, settings.images), ValidationPlan()
    presses = training_presses(plan, data, settings.jobs, progress)
    validation = validation_presses(check, data, settings.jobs, progress)
    chosen = Objective()
    fitted = fit(
        presses,
        validation,
        chosen,
        epochs=settings.epochs,
        seed=settings.seed,
        device=settings.device,
        progress=progress,
        report=_report if progress else lambda epoch, loss, found: None,
    )
    ours = fitted.evidence
    digest = data_sha256(presses)
    story = {
        "name": "vt-vgg",
        "licence": "Apache-2.0",
        "command": f"vtbench train-backbone --seed {settings.seed} --images {settings.images} "
        f"--epochs {settings.epochs} --device {settings.device}",
        "recipe_version": str(RECIPE_VERSION),
        "objective": asdict(chosen),
        "training": asdict(plan),
        "validation": asdict(check),
        "training_data_sha256": digest,
        "best_epoch": str(fitted.best_epoch + 1),
        "evidence": asdict(ours),
        "precision": "bfloat16 products" if reduced_precision(settings.device) else "float32",
        "date": datetime.now(UTC).date().isoformat(),
        "commit": commit,
        "torch": str(torch.__version__),
    }
    size = write_model(path, fitted.weights, story)
    rows = [("vt-vgg", ours), *_beside(validation)]
    if compare:
        for other in (Objective(shapes=0.0), Objective(maps=0.0, shapes=1.0), Objective(pooling="mean")):
            tried = fit(presses, validation, other, epochs=settings.epochs, seed=settings.seed, device=settings.device)
            rows.append((_name(other), tried.evidence))
    return Trained(
        size,
        sha256_of(path),
        digest,
        fitted.best_epoch,
        settings.epochs,
        fitted.seconds,
        tuple((name, (*astuple(row), row.mean)) for name, row in rows),
    )


def _name(objective: object) -> str:
    return "vt-vgg " + ", ".join(f"{key} {value}" for key, value in vars(objective).items())


def _beside(validation: Arrays) -> Iterator[tuple[str, Evidence]]:
    """Evidence of backbones that were not trained here."""
    from fusion.features import get_backbone

    for name in BESIDE:
        backbone = get_backbone(name)
        yield name, evidence(backbone.extract(validation["change"]), backbone.extract(validation["frame"]), validation)


def _report(epoch: int, loss: float, found: Evidence) -> None:
    print(f"epoch {epoch + 1}: loss {loss:.4f}, evidence {100 * found.mean:.1f} %", file=sys.stderr, flush=True)


def _commit() -> str:
    """The commit of the working tree, with a mark where files differ from it; empty outside a clone."""
    from vtbench.run.provenance import provenance

    return str(provenance().get("commit") or "")
