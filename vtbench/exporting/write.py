"""Export: fit, build, check on real samples, and only then write, with the report in the file's metadata."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vtbench.exporting.fit import Fitted, Order, Samples, fit_order

METADATA_KEY = "vtbench"
MOST_BYTES = 2**31 - 1
"""What one ONNX file without external data can hold."""


class NotExactError(Exception):
    """A graph that does not answer as its pipeline does; nothing was written."""


def export(samples: Samples, order: Order, path: Path) -> dict[str, Any]:
    """Fit a pipeline as a run does, write its graph to `path`, and return the report that stands in its metadata.

    Raises:
        ValueError: no exact graph; one line that says what to use instead.
        NotExactError: the graph was made and does not agree with the pipeline.
        OSError: the file cannot be written, or the backbone's weights cannot be had.
    """
    from onnx import helper

    from vtbench.data.files import write_whole
    from vtbench.exporting.graph import build
    from vtbench.exporting.parity import measure
    from vtbench.onnx_eval.offers import offer_of

    fitted = fit_order(samples, order)
    offer = offer_of(samples.task, (samples.path,), samples.data)
    model = build(samples, fitted, offer)
    if model.ByteSize() > MOST_BYTES:
        raise ValueError(
            f"the graph takes {model.ByteSize() / 1e9:.1f} GB, one file holds 2 GB; train on fewer samples"
        )
    rows = fitted.fold.test
    columns = fitted.pipeline.columns(fitted.features(samples, rows))
    parity = measure(model.SerializeToString(), offer, rows, fitted.pipeline.classifier, columns)
    if problem := parity.problem():
        raise NotExactError(f"the graph is not the pipeline: {problem}; nothing was written")
    report = {**_identity(samples, order, fitted), "parity": parity.as_json()}
    helper.set_model_props(model, {METADATA_KEY: json.dumps(report, sort_keys=True)})
    content = model.SerializeToString(deterministic=True)
    write_whole(path, lambda temporary: temporary.write_bytes(content))
    return {**report, "path": str(path), "bytes": len(content)}


def wanted(samples: Samples, order: Order) -> dict[str, Any]:
    """What the report of a file must say for it to be the one that `order` asks for; nothing is fitted for it."""
    from vtbench.environment import version
    from vtbench.tasks.presses import backbone_identity

    modality = order.modality or next(iter(samples.task.modalities))
    variant = order.variant or next(iter(samples.task.variants))
    framed = any(block.from_frames for block in samples.task.modalities[modality].blocks)
    return {
        "task": samples.task.id,
        "variant": variant,
        "modality": modality,
        "method": order.method,
        "split": order.split or next(iter(samples.task.variants[variant].splits)),
        "fit": {"part": order.fit, "seed": order.seed},
        "dataset_hash": samples.dataset_hash,
        **(backbone_identity(samples.backbone) if framed else {}),
        "vtbench": version(),
    }


def made_before(path: Path, asked: Mapping[str, Any]) -> dict[str, Any] | None:
    """Report of the file at `path` if it was exported as `asked` (see `wanted`); None for any other, or none."""
    import onnx

    if not path.is_file():
        return None
    try:
        model = onnx.load(path)
        report = json.loads({each.key: each.value for each in model.metadata_props}[METADATA_KEY])
        same = all(_holds(report[name], value) for name, value in asked.items())
    except Exception:  # a file of somebody else's may be anything
        return None
    return {**report, "path": str(path), "bytes": path.stat().st_size} if same else None


def _holds(found: Any, value: Any) -> bool:
    """Whether a report's entry says the same; of a block, what is asked of it."""
    return all(found[name] == each for name, each in value.items()) if isinstance(value, dict) else found == value


def _identity(samples: Samples, order: Order, fitted: Fitted) -> dict[str, Any]:
    """What decides the file: task, classes, samples, split, method, choices, version."""
    from vtbench.environment import version
    from vtbench.tasks.presses import backbone_identity

    framed = any(block.from_frames for block in fitted.feed.blocks)
    return {
        "task": samples.task.id,
        "variant": fitted.variant,
        "modality": fitted.modality,
        "method": order.method,
        "choices": fitted.setting.as_json(),
        "classes": list(samples.data.classes),
        "split": fitted.split,
        "fit": {"part": order.fit, "fold": fitted.fold.name, "samples": len(fitted.fold.train), "seed": order.seed},
        "checked_on": "the test part" if order.fit == "train" else "the samples it was fitted on",
        "dataset_hash": samples.dataset_hash,
        "unit": "raw counts" if not samples.task.reads_dataset else "newtons",
        **(backbone_identity(samples.backbone) if framed else {}),
        "vtbench": version(),
    }
