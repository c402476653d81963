"""Export: fit, build, check on real samples, and only then write, with the report in the file's metadata."""

from __future__ import annotations

import json
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
    name = f"{samples.task.id}, {fitted.modality}, {fitted.method.id}"
    if problem := parity.problem():
        raise NotExactError(f"{name}: the graph is not the pipeline: {problem}; nothing was written")
    report = {**_identity(samples, order, fitted), "parity": parity.as_json()}
    helper.set_model_props(model, {METADATA_KEY: json.dumps(report, sort_keys=True)})
    content = model.SerializeToString(deterministic=True)
    write_whole(path, lambda temporary: temporary.write_bytes(content))
    return {**report, "path": str(path), "bytes": len(content)}


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
