"""What a run scored through each backbone, and how far two backbones are apart on the same samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from leaderboard.record import Record
from leaderboard.statistics import difference_of
from leaderboard.tally import Tally


@dataclass(frozen=True)
class Score:
    """Accuracy of one cell, 0 to 1, with its 95 % interval, and microseconds a sample of classifier and features."""

    task: str
    variant: str
    split: str
    modality: str
    method: str
    backbone: str
    value: float
    low: float | None
    high: float | None
    predict_us: float | None
    feature_us: float | None
    key: str

    @property
    def protocol(self) -> tuple[str, str, str, str]:
        """Where backbones compete: task, variant, split and modality."""
        return self.task, self.variant, self.split, self.modality


@dataclass(frozen=True)
class Difference:
    """`first` minus `second` of one method, paired over groups, with its 95 % interval and how it was made."""

    task: str
    variant: str
    split: str
    modality: str
    method: str
    first: str
    second: str
    value: float
    low: float
    high: float
    groups: int
    interval: str


def scores(records: list[Record]) -> list[Score]:
    """Scores of the finished cells that are fed frames and nothing else, probes and upper lines apart."""
    found = []
    for record in records:
        who, name = record.identity, record.identity.params.get("backbone")
        if record.status.state != "ok" or who.role != "method" or not isinstance(name, str) or "weights" in who.params:
            continue
        first, cost = record.metrics[0], record.timing
        found.append(
            Score(
                who.task,
                who.variant,
                who.split,
                who.modality,
                who.method,
                name,
                first.value,
                first.low,
                first.high,
                None if cost is None else cost.predict_us_per_sample,
                None if cost is None else cost.feature_us_per_sample,
                record.key,
            )
        )
    return sorted(found, key=lambda s: (s.protocol, s.method, s.backbone))


def differences(found: list[Score], tallies: Mapping[str, Tally], first: str, second: str) -> list[Difference]:
    """Paired differences between two backbones, one for each protocol and method that both have on the same samples."""
    by_name = {(*score.protocol, score.method, score.backbone): score for score in found}
    rows = []
    for score in found:
        other = by_name.get((*score.protocol, score.method, second))
        if score.backbone != first or other is None or not {score.key, other.key} <= set(tallies):
            continue
        ours, theirs = tallies[score.key], tallies[other.key]
        if ours.samples != theirs.samples:
            continue
        gap = difference_of(ours.groups.minus(theirs.groups))
        rows.append(
            Difference(
                *score.protocol, score.method, first, second, gap.value, gap.low, gap.high, gap.groups, gap.method
            )
        )
    return rows
