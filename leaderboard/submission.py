"""What a submission says of itself, and what a record keeps of somebody else's model.

Text in here was written by strangers: it is bounded and free of control characters and markup, and whoever shows it
still escapes it. `status` tells how far a score may be believed:

verified : the model itself ran here, in a sandbox, on recordings of ours.
self-reported : predictions were handed in; that a model made them is the author's word.
flagged : something about it does not fit; `reason` says what.
"""

from __future__ import annotations

import re
import unicodedata
from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

SubmissionStatus = Literal["verified", "self-reported", "flagged"]
STATUSES: tuple[SubmissionStatus, ...] = ("verified", "self-reported", "flagged")

MOST_AUTHORS = 50
MOST_ENTRIES = 40
_MARKUP = re.compile(r"<[A-Za-z!/?]|&#?\w+;")
_LINK = re.compile(r"https?://[A-Za-z0-9.-]+(:\d+)?(/[!-~]*)?")
_SLUG = r"^[a-z0-9][a-z0-9._-]{0,63}$"
_SHA256 = r"^[0-9a-f]{64}$"


def plain_text(value: str) -> str:
    """Return text that is one line of visible characters without markup.

    Raises ValueError for control, private-use or direction-changing characters, markup, and text that is all blank.
    """
    for at, letter in enumerate(value):
        if unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"):
            raise ValueError(f"expected plain text, found the character U+{ord(letter):04X} at place {at + 1}")
    if found := _MARKUP.search(value):
        raise ValueError(f"expected plain text, found markup at {value[found.start() :][:20]!r}")
    if not value.strip():
        raise ValueError("expected some text, found blanks")
    return value.strip()


def web_link(value: str) -> str:
    """Return an http or https address without blanks or quotes; ValueError for anything else."""
    if not _LINK.fullmatch(value) or any(letter in value for letter in "\"'<>`\\"):
        raise ValueError(f"expected an address that begins with https://, got {value[:60]!r}")
    return value


def slug(text: str) -> str:
    """Return text as an id: lower-case letters, digits, '.', '_' and '-', 40 at most; 'model' where nothing is left."""
    folded = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().lower()
    return re.sub(r"[^a-z0-9._]+", "-", folded).strip("-._")[:40].rstrip("-._") or "model"


Line = Annotated[str, Field(max_length=200), AfterValidator(plain_text)]
Title = Annotated[str, Field(max_length=80), AfterValidator(plain_text)]
Link = Annotated[str, Field(max_length=300), AfterValidator(web_link)]


class _Block(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class SubmissionEntry(_Block):
    """One result that is handed in: a model, or the predictions it is said to have made.

    `split` is a split of the task's variant, or "all" for every recording; `claimed` the main score that the authors
    state, as a fraction.
    """

    task: str = Field(min_length=1, max_length=80)
    variant: str | None = Field(default=None, max_length=80)
    split: str | None = Field(default=None, max_length=80)
    fold: str | None = Field(default=None, max_length=80)
    model: str | None = Field(default=None, max_length=120)
    predictions: str | None = Field(default=None, max_length=120)
    claimed: float | None = Field(default=None, ge=0, le=1)

    @model_validator(mode="after")
    def _one_artifact(self) -> SubmissionEntry:
        if (self.model is None) == (self.predictions is None):
            raise ValueError("expected a model or predictions, one of the two")
        return self


class SubmissionFile(_Block):
    """`submission.yaml`: who hands in what.

    `trained_on` and `hardware` are the authors' words; nothing in the harness relies on them.
    """

    id: str = Field(pattern=_SLUG)
    title: Title
    authors: tuple[Title, ...] = Field(min_length=1, max_length=MOST_AUTHORS)
    licence: Title
    trained_on: Line
    link: Link | None = None
    hardware: Line | None = None
    entries: tuple[SubmissionEntry, ...] = Field(min_length=1, max_length=MOST_ENTRIES)


class Latency(_Block):
    """Time of one call on a batch, in milliseconds, over `calls` calls after warm-up; `first_ms` before any."""

    batch: int = Field(ge=1)
    calls: int = Field(ge=1)
    min_ms: float = Field(ge=0)
    p50_ms: float = Field(ge=0)
    p95_ms: float = Field(ge=0)
    first_ms: float | None = Field(default=None, ge=0)


class Artifact(_Block):
    """What was run, what it costs without a clock, and in what it was locked.

    `protections` says of each protection what held, or why it did not; `load_s` is reading and optimising the graph.
    """

    sha256: str = Field(pattern=_SHA256)
    size_bytes: int = Field(ge=0)
    parameters: int | None = Field(default=None, ge=0)
    nodes: int | None = Field(default=None, ge=0)
    inputs: tuple[str, ...] = ()
    load_s: float | None = Field(default=None, ge=0)
    peak_rss_mb: float | None = Field(default=None, ge=0)
    latency: tuple[Latency, ...] = ()
    runtime: str = ""
    protections: dict[str, str] = Field(default_factory=dict)


class Submission(_Block):
    """Where a record of somebody else's model comes from; `hidden` is the commitment to a hidden test set's seed."""

    id: str = Field(pattern=_SLUG)
    title: Title
    status: SubmissionStatus
    reason: Annotated[str, Field(max_length=1000)] = ""
    authors: tuple[Title, ...] = Field(default=(), max_length=MOST_AUTHORS)
    licence: Title | None = None
    link: Link | None = None
    hardware: Line | None = None
    trained_on: Line | None = None
    claimed: float | None = Field(default=None, ge=0, le=1)
    hidden: str | None = Field(default=None, pattern=_SHA256)
    artifact: Artifact | None = None

    @model_validator(mode="after")
    def _explained(self) -> Submission:
        if self.status == "flagged" and not self.reason.strip():
            raise ValueError("status 'flagged' needs a reason")
        return self
