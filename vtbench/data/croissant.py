"""`croissant.json`: the dataset described in MLCommons' Croissant 1.0, for tools that know nothing of vtbench.

The file follows from `dataset.json` alone, so that it has the same bytes wherever the dataset was written; it holds no
date. Every shard is listed with its SHA-256, and one record set, `recordings`, has a field for each Parquet column.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pyarrow as pa

from vtbench.data.format import CROISSANT_FILE, IMAGE, arrow_schema
from vtbench.data.meta import DatasetMeta

RECORDS = "recordings"
_SHARDS = "shards"
_PARQUET = "application/x-parquet"
_APACHE = "https://www.apache.org/licenses/LICENSE-2.0"

_CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "dct": "http://purl.org/dc/terms/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "sc": "https://schema.org/",
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
    **{
        term: f"cr:{term}"
        for term in (
            *("citeAs", "column", "equivalentProperty", "extract", "field", "fileObject", "fileProperty", "fileSet"),
            *("format", "includes", "isLiveDataset", "jsonPath", "key", "md5", "parentField", "path", "recordSet"),
            *("references", "regex", "repeated", "replace", "samplingRate", "separator", "source", "subField"),
            "transform",
        )
    },
}

_ABOUT = {
    "id": "name of the recording, unique",
    "object": "name of the object",
    "label": "index of the object among the classes",
    "press": "deep or shallow",
    "unit": "which sensor of its kind",
    "session": "which sitting, counted within a unit",
    "round": "how-many-th press of its object",
    "seed": "run seed",
    "image": "camera frame at the hold",
    "image_rest": "frame of the same camera before contact",
    "force": "force of each taxel over the hold, newtons",
    "taxel_load": "true load of each taxel at the hold, newtons",
    "force_series": "forces in time, one row of taxels a sample, newtons",
    "rate_hz": "sampling rate of the forces, hertz",
    "hold_start": "first sample of the hold",
    "hold_stop": "sample after the hold",
    "image_time_s": "time of the frame on the clock of the forces, seconds",
    "total_force_n": "total normal force, newtons",
    "indentation_mm": "indentation, millimetres",
    "pose_x_mm": "position of the object, millimetres",
    "pose_y_mm": "position of the object, millimetres",
    "pose_deg": "angle of the object, degrees",
    "kind": "kind of the trial",
    "trial": "number of the trial",
    "speed_mm_s": "sliding speed, millimetres a second",
    "rotation_deg_s": "rate of turn, degrees a second",
    "load_n": "normal load, newtons",
    "direction_deg": "direction of sliding, degrees",
    "onset": "first sample of gross slip; empty without",
    "state": "contact at each sample: 0 stick, 1 partial slip, 2 gross slip",
    "frames": "camera frames of the trial",
    "frame_time_s": "time of each frame on the clock of the forces, seconds",
    "truth_displacement": "true displacement of the skin, metres",
    "truth_pressure": "true pressure on the skin, pascals",
    "truth_contact": "where the object touches",
}


def croissant(meta: DatasetMeta) -> dict[str, Any]:
    """The Croissant description of a dataset, as JSON values."""
    schema = arrow_schema(meta.columns, meta.n_taxels, meta.truth, meta.classes)
    source = meta.source or {}
    licence = _APACHE if meta.kind == "simulated" else source.get("license")
    ours = f"{meta.name}, seed {meta.seed}, vtbench {meta.generator.get('vtbench', '')}"
    cite = ours if meta.kind == "simulated" else source.get("citation")
    return {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": meta.name,
        "description": _description(meta),
        **({"license": licence} if licence else {}),
        **({"citeAs": cite} if cite else {}),
        "version": f"{meta.schema_version}.0.0",
        "keywords": ["tactile sensing", "visuo-tactile", meta.kind, meta.recordings],
        "distribution": [
            {
                "@type": "cr:FileSet",
                "@id": _SHARDS,
                "name": _SHARDS,
                "description": "the Parquet shards, in the order of their names",
                "encodingFormat": _PARQUET,
                "includes": "shard-*.parquet",
            },
            *(
                {
                    "@type": "cr:FileObject",
                    "@id": shard.name,
                    "name": shard.name,
                    "description": f"{shard.rows} {meta.recordings}",
                    "contentUrl": shard.name,
                    "contentSize": f"{shard.bytes} B",
                    "encodingFormat": _PARQUET,
                    "sha256": shard.sha256,
                }
                for shard in meta.shards
            ),
        ],
        "recordSet": [
            {
                "@type": "cr:RecordSet",
                "@id": RECORDS,
                "name": RECORDS,
                "description": f"one record for each of the {meta.samples} {meta.recordings}",
                "key": {"@id": f"{RECORDS}/id"},
                "field": [_field(field) for field in schema],
            }
        ],
    }


def croissant_text(meta: DatasetMeta) -> str:
    """What `croissant.json` holds: the same text for the same `dataset.json`."""
    return json.dumps(croissant(meta), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def croissant_problem(folder: Path, meta: DatasetMeta) -> str | None:
    """What is wrong with the file in `folder`, in one line; None when it is the one that belongs to `meta`."""
    path = folder / CROISSANT_FILE
    again = "; the command that made the dataset writes it again"
    if not path.is_file():
        return f"{CROISSANT_FILE}: missing{again}"
    if path.read_bytes() != croissant_text(meta).encode():
        return f"{CROISSANT_FILE}: does not describe this dataset{again}"
    return None


def _description(meta: DatasetMeta) -> str:
    height, width = meta.image_size
    frames = f", frames of {height}x{width} pixels" if height else ""
    return (
        f"{meta.samples} {meta.kind} {meta.recordings} of {len(meta.classes)} objects: forces of {meta.n_taxels} "
        f"taxels{frames}. Classes: {', '.join(meta.classes)}."
    )


def _field(field: pa.Field) -> dict[str, Any]:
    """A column; the pictures are the bytes inside their struct."""
    kind, repeated = field.type, False
    while pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind):
        kind, repeated = kind.value_type, True
    source: dict[str, Any] = {"fileSet": {"@id": _SHARDS}, "extract": {"column": field.name}}
    if kind == IMAGE:
        source["transform"] = {"jsonPath": "bytes"}
    return {
        "@type": "cr:Field",
        "@id": f"{RECORDS}/{field.name}",
        "name": field.name,
        "description": _ABOUT[field.name],
        "dataType": _data_type(kind),
        **({"repeated": True} if repeated else {}),
        "source": source,
    }


def _data_type(kind: pa.DataType) -> str:
    if kind == IMAGE:
        return "sc:ImageObject"
    if pa.types.is_boolean(kind):
        return "sc:Boolean"
    if pa.types.is_integer(kind):
        return "sc:Integer"
    return "sc:Float" if pa.types.is_floating(kind) else "sc:Text"
