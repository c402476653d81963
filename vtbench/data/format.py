"""What a dataset on disk looks like: file names, Parquet columns, and how a field becomes a column type."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import pyarrow as pa

SCHEMA_VERSION = 1
META_FILE = "dataset.json"
PARTIAL_FILE = "dataset.partial.json"
CROISSANT_FILE = "croissant.json"
SAMPLES_PER_SHARD = 27

PRESSES = ("deep", "shallow")
TRUTH_UNITS = {"displacement": "m", "pressure": "Pa", "contact": "bool"}

REQUIRED_COLUMNS = ("id", "object", "label", "press", "unit", "session", "round", "image", "force")

_SCALARS: dict[str, pa.DataType] = {
    "id": pa.string(),
    "object": pa.string(),
    "label": pa.int64(),
    "press": pa.string(),
    "unit": pa.int32(),
    "session": pa.int32(),
    "round": pa.int32(),
    "seed": pa.int64(),
    "rate_hz": pa.float64(),
    "hold_start": pa.int32(),
    "hold_stop": pa.int32(),
    "image_time_s": pa.float64(),
    "total_force_n": pa.float64(),
    "indentation_mm": pa.float64(),
    "pose_x_mm": pa.float64(),
    "pose_y_mm": pa.float64(),
    "pose_deg": pa.float64(),
    "kind": pa.string(),
    "trial": pa.int32(),
    "speed_mm_s": pa.float64(),
    "rotation_deg_s": pa.float64(),
    "load_n": pa.float64(),
    "direction_deg": pa.float64(),
    "onset": pa.int32(),
}
NULLABLE = ("onset",)
"""Columns in which a missing value means something: a trial without gross slip has no onset."""
IMAGE = pa.struct([pa.field("bytes", pa.binary()), pa.field("path", pa.string())])
_LISTS = {"state": pa.uint8(), "frames": IMAGE, "frame_time_s": pa.float64()}

SIMULATED_COLUMNS = (
    *("id", "object", "label", "press", "unit", "session", "round", "seed", "image", "image_rest"),
    *("force", "taxel_load", "force_series", "rate_hz", "hold_start", "hold_stop", "image_time_s"),
    *("total_force_n", "indentation_mm", "pose_x_mm", "pose_y_mm", "pose_deg"),
)
SLIDE_COLUMNS = (
    *("id", "object", "label", "kind", "trial", "unit", "session", "seed"),
    *("speed_mm_s", "rotation_deg_s", "load_n", "direction_deg"),
    *("rate_hz", "onset", "force_series", "state"),
)
FRAME_COLUMNS = ("frames", "frame_time_s")
SLIDE_STATES = ("stick", "partial slip", "gross slip")
"""What the values 0, 1, 2 of a slide's `state` mean."""


def shard_name(number: int) -> str:
    """File name of shard `number`, counted from zero."""
    return f"shard-{number:05d}.parquet"


def fixed_list(item: pa.DataType, size: int) -> pa.DataType:
    """A list of exactly `size` items, its child named as Parquet names it."""
    return pa.list_(pa.field("element", item), size)


def column_type(name: str, n_taxels: int, truth: Mapping[str, Sequence[int]]) -> pa.DataType:
    """Arrow type of column `name` for `n_taxels` taxels and truth grids of the given (rows, columns)."""
    if name in _SCALARS:
        return _SCALARS[name]
    if name in ("image", "image_rest"):
        return IMAGE
    if name in ("force", "taxel_load"):
        return fixed_list(pa.float32(), n_taxels)
    if name in _LISTS:
        return pa.list_(pa.field("element", _LISTS[name]))
    if name == "force_series":
        return pa.list_(pa.field("element", fixed_list(pa.float32(), n_taxels)))
    field = name.removeprefix("truth_")
    if field in truth:
        rows, columns = truth[field]
        item = pa.bool_() if TRUTH_UNITS[field] == "bool" else pa.float32()
        return fixed_list(fixed_list(item, columns), rows)
    raise ValueError(f"column {name!r} is not part of the dataset format")


def arrow_schema(
    columns: Sequence[str], n_taxels: int, truth: Mapping[str, Sequence[int]], classes: Sequence[str]
) -> pa.Schema:
    """Parquet schema of every shard; its metadata tells Hugging Face `datasets` how to decode the images."""
    fields = [pa.field(name, column_type(name, n_taxels, truth)) for name in columns]
    return hugging_face_schema(fields, classes if "label" in columns else ())


def hugging_face_schema(fields: Sequence[pa.Field], classes: Sequence[str] = ()) -> pa.Schema:
    """Schema whose metadata tells Hugging Face `datasets` of the images, and of the names of `label`."""
    features: dict[str, Any] = {field.name: _hugging_face(field.type) for field in fields}
    if classes:
        features["label"] = {"names": list(classes), "_type": "ClassLabel"}
    note = json.dumps({"info": {"features": features}}, sort_keys=True, separators=(",", ":"))
    return pa.schema(fields, metadata={"huggingface": note})


def _hugging_face(kind: pa.DataType) -> dict[str, Any]:
    """Description of an Arrow type in the form that Hugging Face `datasets` keeps in a Parquet schema."""
    if kind == IMAGE:
        return {"_type": "Image"}
    if pa.types.is_fixed_size_list(kind):
        return {"feature": _hugging_face(kind.value_type), "length": kind.list_size, "_type": "Sequence"}
    if pa.types.is_list(kind):
        return {"feature": _hugging_face(kind.value_type), "_type": "Sequence"}
    names = {pa.float64(): "float64", pa.float32(): "float32"}
    return {"dtype": names.get(kind, str(kind)), "_type": "Value"}


def canonical_json(value: object) -> str:
    """JSON with sorted keys and no spaces: equal values give equal text."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
