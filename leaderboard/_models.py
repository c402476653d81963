"""The record of one cell of a benchmark: what was run, how it ended, what it scored, what it cost, where it ran."""

from __future__ import annotations

import hashlib
import json
from typing import Literal

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, JsonValue, model_validator

from leaderboard.submission import Submission

SCHEMA_VERSION: Literal[1] = 1

Role = Literal["method", "probe", "law", "upper-line"]
Kind = Literal["simulated", "real"]
State = Literal["ok", "failed", "timeout", "skipped"]


class _Block(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Identity(_Block):
    """What decides a result. Two records with equal identities are the same cell, and share a key.

    `split` is "random", "held-out-unit", "held-out-setting", ...; `method` and `modality` are ids, shown as they are
    unless the board knows a better title. `params` holds the method's parameters as JSON values. `dataset` is a
    name for people, `dataset_hash` the content hash that the dataset's own metadata states.
    """

    task: str = Field(min_length=1)
    variant: str
    split: str
    method: str = Field(min_length=1)
    modality: str
    role: Role = "method"
    kind: Kind
    params: dict[str, JsonValue] = Field(default_factory=dict)
    seed: int
    dataset: str
    dataset_hash: str
    protocol_version: int = Field(ge=1)


class Status(_Block):
    """How the cell ended; anything but "ok" states its reason in one line, the way out of it included."""

    state: State
    reason: str = ""

    @model_validator(mode="after")
    def _explained(self) -> Status:
        if self.state != "ok" and not self.reason.strip():
            raise ValueError(f"status '{self.state}' needs a reason")
        return self


class Metric(_Block):
    """One score. A record's first metric is the one that tables show.

    `unit` "fraction" is printed in percent; any other unit is printed as it stands. `low`..`high` is the 95 %
    interval and `interval` the name of its method; `n` counts predictions and `groups` the independent groups.
    """

    name: str = Field(min_length=1)
    value: float
    unit: str = "fraction"
    direction: Literal["higher", "lower"] = "higher"
    n: int = Field(ge=0)
    groups: int = Field(ge=0)
    low: float | None = None
    high: float | None = None
    interval: str = ""

    @model_validator(mode="after")
    def _ordered(self) -> Metric:
        if (self.low is None) != (self.high is None):
            raise ValueError(f"metric '{self.name}': expected both ends of the interval or neither")
        if self.low is not None and self.high is not None and self.low > self.high:
            raise ValueError(f"metric '{self.name}': interval {self.low}..{self.high} is upside down")
        return self


class Timing(_Block):
    """What the cell cost. `predict_us_per_sample` is the method alone, `feature_us_per_sample` what feeds it.

    `note` says how the figures were taken; `predict_low_us`..`predict_high_us` is an interval where one was measured.
    """

    threads: int = Field(ge=1)
    batch: int | None = Field(default=None, ge=1)
    fit_s: float | None = Field(default=None, ge=0)
    predict_us_per_sample: float | None = Field(default=None, ge=0)
    predict_low_us: float | None = Field(default=None, ge=0)
    predict_high_us: float | None = Field(default=None, ge=0)
    feature_us_per_sample: float | None = Field(default=None, ge=0)
    peak_rss_mb: float | None = Field(default=None, ge=0)
    note: str = ""


class Verdict(_Block):
    """Whether a law held: the law in words, what it demands and what was seen."""

    law: str = Field(min_length=1)
    expected: str
    observed: str
    passed: bool


class Provenance(_Block):
    """Where a record comes from. `fingerprint` names the machine: speeds compare only under equal fingerprints."""

    version: str
    commit: str = ""
    python: str
    packages: dict[str, str] = Field(default_factory=dict)
    machine: dict[str, JsonValue] = Field(default_factory=dict)
    fingerprint: str
    started: AwareDatetime
    finished: AwareDatetime


class Record(_Block):
    """Everything kept of one cell. `key` must be `record_key(identity)`; `verdict` belongs to the role "law".

    `submission` is there where the model or its predictions are somebody else's.
    """

    schema_version: Literal[1] = SCHEMA_VERSION
    key: str
    identity: Identity
    status: Status
    metrics: tuple[Metric, ...] = ()
    timing: Timing | None = None
    verdict: Verdict | None = None
    submission: Submission | None = None
    provenance: Provenance

    @model_validator(mode="after")
    def _consistent(self) -> Record:
        expected = record_key(self.identity)
        if self.key != expected:
            raise ValueError(f"key: expected the hash of the identity, {expected[:12]}..., got '{self.key[:12]}'")
        if self.status.state == "ok" and not self.metrics and self.verdict is None:
            raise ValueError("status is 'ok' but there is neither a metric nor a verdict")
        return self


def canonical_json(value: JsonValue) -> str:
    """Return JSON with sorted keys and no spaces; ValueError for NaN or infinity, which have no JSON."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def record_key(identity: Identity) -> str:
    """Return the SHA-256 (hex) of the identity's canonical JSON: the name of its folder and of its row."""
    return hashlib.sha256(canonical_json(identity.model_dump(mode="json")).encode()).hexdigest()
