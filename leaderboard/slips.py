"""What the records of slip tasks say, by name: `what@rate[factor=value]`, delays in milliseconds."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from leaderboard.record import Metric, Record

MISSED_MS = 1e9
"""A delay that stands for a miss: JSON has no infinity. The median of delays is one where most slips are missed."""
BASELINE = "energy"
SUPPORTED = 30.0
"""Expected false alarms from which on a rate is measured rather than extrapolated."""
_NAME = re.compile(r"(?P<what>\w+)(?:@(?P<rate>[\d.]+))?(?:\[(?P<factor>\w+)=(?P<value>[^\]]+)\])?")


@dataclass(frozen=True)
class SlipName:
    """The parts of a metric's name; `rate` in false alarms a minute, None at the training trials' threshold."""

    what: str
    rate: float | None
    factor: str
    value: str


def parse(name: str) -> SlipName | None:
    """The parts of a metric's name, None where it is not of that form."""
    match = _NAME.fullmatch(name)
    if match is None:
        return None
    rate = match["rate"]
    return SlipName(match["what"], None if rate is None else float(rate), match["factor"] or "", match["value"] or "")


def is_slip(record: Record) -> bool:
    """Whether a record is one of a slip task."""
    return record.identity.task.startswith("slip/")


def metric(record: Record, what: str, rate: float | None = None, factor: str = "", value: str = "") -> Metric | None:
    """The record's metric of that name, None without."""
    wanted = SlipName(what, rate, factor, value)
    return next((each for each in record.metrics if parse(each.name) == wanted), None)


def rates(records: Iterable[Record]) -> list[float]:
    """Rates of false alarms at which the records hold delays, rising."""
    found = {parsed.rate for record in records for each in record.metrics if (parsed := parse(each.name))}
    return sorted(rate for rate in found if rate is not None)


def levels(records: Iterable[Record], what: str, factor: str) -> list[str]:
    """Values of a factor for which the records hold a metric, in the order in which they come."""
    found: dict[str, None] = {}
    for record in records:
        for each in record.metrics:
            parsed = parse(each.name)
            if parsed is not None and parsed.what == what and parsed.factor == factor:
                found[parsed.value] = None
    return list(found)
