"""`dataset.json`: what a dataset was made from and what its shards must be."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from vtbench.data.format import META_FILE, SCHEMA_VERSION, canonical_json

_M = TypeVar("_M", bound=BaseModel)

Recordings = Literal["presses", "slides"]


class _Frozen(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class ShardEntry(_Frozen):
    """One Parquet file: its name, number of rows, size in bytes and SHA-256."""

    name: str = Field(pattern=r"^shard-\d{5,}\.parquet$")
    rows: int = Field(gt=0)
    bytes: int = Field(gt=0)
    sha256: str = Field(pattern=r"^[0-9a-f]{64}$")


class Plan(_Frozen):
    """All that decides a dataset's bytes, known before the first shard is written.

    `source` says where imported recordings came from; `scene`, `sensor` and `seed` say what was simulated.
    `recordings` are presses, or slides: trials in time with the state of the contact.
    `image_size` is (height, width), zeros where there are no frames; `truth` maps a stored ground-truth field to its
    grid (rows, columns).
    """

    schema_version: int = SCHEMA_VERSION
    kind: Literal["simulated", "imported"]
    recordings: Recordings = "presses"
    name: str
    generator: dict[str, str]
    scene: dict[str, Any] | None = None
    sensor: dict[str, Any] | None = None
    source: dict[str, Any] | None = None
    seed: int | None = None
    samples: int = Field(gt=0)
    samples_per_shard: int = Field(gt=0)
    classes: tuple[str, ...]
    n_taxels: int = Field(gt=0)
    rate_hz: float | None = None
    image_size: tuple[int, int]
    truth: dict[str, tuple[int, int]] = {}
    columns: tuple[str, ...]

    @property
    def n_shards(self) -> int:
        """Number of shards the samples fill."""
        return -(-self.samples // self.samples_per_shard)

    def shard_rows(self, number: int) -> range:
        """Sample indices held by shard `number`."""
        first = number * self.samples_per_shard
        return range(first, min(first + self.samples_per_shard, self.samples))


class DatasetMeta(Plan):
    """The plan, the shards it became, and `hash`, which changes when any byte of any shard does."""

    shards: tuple[ShardEntry, ...]
    hash: str

    @classmethod
    def of(cls, plan: Plan, shards: tuple[ShardEntry, ...]) -> Self:
        """Complete a plan with its finished shards."""
        return cls(**plan.model_dump(), shards=shards, hash=content_hash(plan, shards))

    @property
    def plan(self) -> Plan:
        """The plan without what came of it."""
        return Plan(**self.model_dump(exclude={"shards", "hash"}))


class Progress(_Frozen):
    """What `dataset.partial.json` holds: the plan and the shards that are whole on disk."""

    plan: Plan
    shards: tuple[ShardEntry, ...] = ()


def content_hash(plan: Plan, shards: tuple[ShardEntry, ...]) -> str:
    """SHA-256 over the canonical JSON of the schema, the classes and the shards' checksums."""
    content = {
        "schema_version": plan.schema_version,
        "columns": plan.columns,
        "classes": plan.classes,
        "n_taxels": plan.n_taxels,
        "image_size": plan.image_size,
        "truth": plan.truth,
        "shards": [{"name": s.name, "rows": s.rows, "sha256": s.sha256} for s in shards],
    }
    return hashlib.sha256(canonical_json(content).encode()).hexdigest()


def read_model(path: Path, model: type[_M]) -> _M:
    """Read a JSON file into `model`; a ValueError of one line says what is wrong with it and where."""
    try:
        return model.model_validate(json.loads(path.read_text(encoding="utf-8")))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: not readable as JSON ({error}); fetch or generate it again") from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "top level"
        raise ValueError(f"{path}: {where}: {first['msg']}") from error


def read_meta(folder: Path) -> DatasetMeta:
    """`dataset.json` of a finished dataset; ValueError when missing, damaged or of another schema version."""
    path = folder / META_FILE
    if not path.is_file():
        raise ValueError(
            f"{folder}: no {META_FILE} here; expected a finished dataset (an unfinished one goes on when the "
            "command that began it is run again)"
        )
    meta = read_model(path, DatasetMeta)
    if meta.schema_version != SCHEMA_VERSION:
        raise ValueError(
            f"{path}: schema version {meta.schema_version}, this vtbench reads {SCHEMA_VERSION}; "
            "generate the dataset again"
        )
    return meta


def first_difference(there: object, asked: object, key: str = "") -> str | None:
    """The first difference of two JSON values, as `key is A there, B asked` or `key has A there`; None if equal."""
    if isinstance(there, Mapping) and isinstance(asked, Mapping):
        for name in sorted({*there, *asked}):
            inner = f"{key}.{name}" if key else str(name)
            if found := first_difference(there.get(name), asked.get(name), inner):
                return found
        return None
    if isinstance(there, list) and isinstance(asked, list):
        # long lists begin alike: what one of them has and the other has not tells them apart
        for more, verb, other in ((there, "has", asked), (asked, "lacks", there)):
            if names := [item for item in more if item not in other]:
                return f"{key} {verb} {', '.join(map(str, names[:4]))} there"
    return None if there == asked else f"{key} is {_short(there)} there, {_short(asked)} asked"


def _short(value: object, limit: int = 40) -> str:
    text = canonical_json(value)
    return text if len(text) <= limit else text[: limit - 3] + "..."
