"""The record of something that was handed in: whose it is, on what it was tested, how far its score may be believed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from leaderboard.record import Identity, Metric, Provenance, Record, Status, Timing, record_key, scan_records
from leaderboard.submission import Artifact, Submission, SubmissionStatus
from vtbench.onnx_eval.tested import Tested
from vtbench.run.cells import PROTOCOL_VERSION

CONTRACT_VERSION = 1


@dataclass(frozen=True)
class Credit:
    """Who hands something in, as its record will say; `more` are further fields of `Submission`."""

    id: str
    title: str
    more: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Result:
    """What came out: how it ended, scores, cost, and the doubts that flag it."""

    status: Status
    metrics: tuple[Metric, ...] = ()
    timing: Timing | None = None
    doubts: Sequence[str] = ()
    modality: str = "unknown"


def record_of(
    result: Result,
    tested: Tested,
    credit: Credit,
    artifact: Artifact,
    started: datetime,
    believed: SubmissionStatus,
    others: Sequence[str],
) -> Record:
    """The record; `believed` is its status without a doubt, `others` are doubts from outside (see `copies`)."""
    from vtbench.run.provenance import provenance

    identity = Identity(
        task=tested.task.id,
        variant=tested.variant,
        split=tested.split.name,
        method=f"{credit.id}@{artifact.sha256[:8]}",
        modality=result.modality,
        kind=tested.kind,
        params={"artifact": artifact.sha256, "contract": CONTRACT_VERSION, **tested.params()},
        seed=tested.seed,
        dataset=tested.dataset,
        dataset_hash=tested.dataset_hash,
        protocol_version=PROTOCOL_VERSION,
    )
    doubts = [*result.doubts, *tested.doubts(credit.more.get("claimed"), result.metrics), *others]
    submission = Submission(
        id=credit.id,
        title=credit.title,
        status="flagged" if doubts else believed,
        reason="; ".join(doubts)[:1000],
        hidden=tested.hidden,
        artifact=artifact,
        **credit.more,
    )
    return Record(
        key=record_key(identity),
        identity=identity,
        status=result.status,
        metrics=result.metrics,
        timing=result.timing,
        submission=submission,
        provenance=Provenance(**provenance(), started=started, finished=datetime.now(UTC)),
    )


def copies(out: Path, sha256: str, own_id: str) -> list[str]:
    """A doubt where another submission in `out` handed in the same bytes."""
    if not (out / "runs").is_dir():
        return []
    handed_in = [record.submission for record in scan_records(out)[0] if record.submission is not None]
    others = {each.id for each in handed_in if each.artifact and each.artifact.sha256 == sha256} - {own_id}
    return [f"the same file as handed in by {', '.join(sorted(others))}"] if others else []
