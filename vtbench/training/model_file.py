"""The trained network as an ONNX file that says how it was made."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.features.vt_vgg import build
from vtbench.data.files import write_whole

LARGEST_BYTES = 8_000_000


def write_model(path: Path, weights: Mapping[str, NDArray[np.float32]], story: Mapping[str, object]) -> int:
    """Write the graph of `weights` with `story` in its metadata, whole or not at all; returns its size in bytes.

    ValueError where it would be larger than 8 MB.
    """
    import onnx

    model = onnx.load_from_string(build(weights))
    onnx.helper.set_model_props(model, {key: _text(value) for key, value in sorted(story.items())})
    content = model.SerializeToString(deterministic=True)
    if len(content) > LARGEST_BYTES:
        raise ValueError(f"{path}: the model would take {len(content)} bytes, expected at most {LARGEST_BYTES}")
    write_whole(path, lambda temporary: temporary.write_bytes(content))
    return len(content)


def read_story(path: Path) -> dict[str, str]:
    """Metadata of a model file: how it was made."""
    import onnx

    return {entry.key: entry.value for entry in onnx.load(path).metadata_props}


def _text(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value, sort_keys=True)
