"""Records of slip tasks, sorted into blocks that compare, and what they say of each detector against the baseline."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import pandas as pd

from leaderboard.labels import beside, labels
from leaderboard.names import METHODS, MODALITIES, SPLITS, order, title
from leaderboard.record import Record
from leaderboard.slips import BASELINE, MISSED_MS, SUPPORTED, is_slip, levels, metric, parse, rates

PAPERS_DETECTOR = "covariance"
BOTH_MISS = "both miss most slips"


@dataclass(frozen=True)
class SlipBlock:
    """Results on the same trials with the same protocol: what may be compared.

    `label` names the trials where another block has the same protocol.
    """

    task: str
    variant: str
    kind: str
    dataset: str
    dataset_hash: str
    records: tuple[Record, ...]
    label: str = ""

    @property
    def protocol(self) -> str:
        """The variant, with the trials where another block is of the same one."""
        return beside(self.variant, self.label)

    @property
    def splits(self) -> list[str]:
        """Splits in the board's order."""
        return sorted({r.identity.split for r in self.records}, key=lambda name: order(SPLITS, name))

    def of(self, split: str) -> list[Record]:
        """Scored records of a split, by threshold rule and detector; no probes."""
        mine = [r for r in self.records if r.identity.split == split and r.identity.role == "method" and r.metrics]
        return sorted(mine, key=lambda r: (order(MODALITIES, r.identity.modality), order(METHODS, r.identity.method)))


def slip_blocks(records: Iterable[Record]) -> tuple[SlipBlock, ...]:
    """Blocks of the slip records among these; of records of the same cell the last started."""
    cells: dict[tuple[object, ...], Record] = {}
    for record in filter(is_slip, records):
        who = record.identity
        cell = (who.task, who.variant, who.dataset_hash, who.kind, who.split, who.role, who.modality, who.method)
        if cell not in cells or record.provenance.started >= cells[cell].provenance.started:
            cells[cell] = record
    grouped: dict[tuple[str, str, str, str, str], list[Record]] = {}
    for record in cells.values():
        who = record.identity
        grouped.setdefault((who.task, who.variant, who.kind, who.dataset, who.dataset_hash), []).append(record)
    names = sorted(grouped)
    named = labels([name[:3] for name in names], [name[3] for name in names], [name[4] for name in names])
    return tuple(SlipBlock(*name, tuple(grouped[name]), label) for name, label in zip(names, named, strict=True))


def metrics_frame(blocks: Iterable[SlipBlock]) -> pd.DataFrame:
    """Every metric of every block, a row each, its name in parts."""
    rows = []
    for block in blocks:
        for record in block.records:
            who = record.identity
            for each in record.metrics:
                name = parse(each.name)
                if name is None:
                    continue
                rows.append(
                    {
                        "task": block.task,
                        "variant": block.variant,
                        "split": who.split,
                        "role": who.role,
                        "threshold": who.modality,
                        "detector": who.method,
                        "what": name.what,
                        "per_minute": name.rate,
                        "factor": name.factor,
                        "level": name.value,
                        **each.model_dump(include={"value", "low", "high", "unit", "n", "interval"}),
                        "key": record.key,
                    }
                )
    return pd.DataFrame(rows)


def verdicts(block: SlipBlock) -> list[str]:
    """A sentence for each split and rule: where the paper's detector loses to the energy baseline, and where it wins.

    Judged by the paired interval of the median delays alone; an area is no verdict.
    """
    sentences = []
    for split in block.splits:
        for record in block.of(split):
            has_delays = any(metric(record, "delay_ms", rate) for rate in rates([record]))
            if record.identity.method == PAPERS_DETECTOR and has_delays:
                said = ", ".join(_at(record, rate) for rate in rates([record]))
                rule = title(MODALITIES, record.identity.modality)
                sentences.append(
                    f"{block.task}, {block.protocol}, {title(SPLITS, split)}, {rule}: "
                    f"the covariance detector against the energy baseline: {said}.{_by_kind(record)}"
                )
    return sentences


def _by_kind(record: Record) -> str:
    """A second sentence where single kinds of disturbance tell the two apart."""
    rate = max(rates([record]))
    parts = []
    for judged, said in (("later", "it loses to energy beside"), ("earlier", "it alarms earlier beside")):
        kinds = levels([record], "delay_minus_energy_ms", "negatives")
        mine = [kind for kind in kinds if compared(record, rate, "negatives", kind) == judged]
        if mine:
            named = ", ".join(f"{kind.replace('_', ' ')} {_ends(record, rate, kind)}" for kind in mine)
            parts.append(f"{said} {named}")
    if not parts:
        return ""
    return f" With one kind of disturbance at a time, at {rate:g} a minute, {'; '.join(parts)}."


def _ends(record: Record, rate: float, kind: str) -> str:
    difference = metric(record, "delay_minus_energy_ms", rate, "negatives", kind)
    assert difference is not None
    assert difference.low is not None
    assert difference.high is not None
    return f"({signed(difference.low)} to {signed(difference.high)} ms)"


def compared(record: Record, rate: float, factor: str = "", value: str = "") -> str:
    """`earlier`, `later` or `no difference` against the baseline at a rate, by the paired interval; or why not."""
    difference = metric(record, "delay_minus_energy_ms", rate, factor, value)
    delay = metric(record, "delay_ms", rate, factor, value)
    if difference is None or difference.low is None or difference.high is None or delay is None:
        return "unknown"
    if difference.value == 0 and delay.value >= MISSED_MS / 2:
        return BOTH_MISS
    if difference.high < 0:
        return "earlier"
    return "later" if difference.low > 0 else "no difference"


def supported(record: Record, rate: float) -> bool:
    """Whether the trials hold enough time without slip for a rate of false alarms."""
    expected = metric(record, "expected_alarms", rate)
    return expected is not None and expected.value >= SUPPORTED


def _at(record: Record, rate: float) -> str:
    words = {"earlier": "it alarms earlier", "later": "it loses"}
    judged = compared(record, rate)
    difference = metric(record, "delay_minus_energy_ms", rate)
    ends = ""
    if difference is not None and difference.low is not None and difference.high is not None and judged != BOTH_MISS:
        ends = f" ({signed(difference.low)} to {signed(difference.high)} ms)"
    weak = "" if supported(record, rate) else ", too little time to support the rate"
    return f"at {rate:g} false alarms a minute {words.get(judged, judged)}{ends}{weak}"


def signed(ms: float) -> str:
    """A difference of delays in milliseconds; beyond all delays where one side misses most slips."""
    if abs(ms) >= MISSED_MS / 2:
        return "+∞" if ms > 0 else "−∞"
    return f"{ms:+.0f}".replace("-", "−")


__all__ = ["BASELINE", "SlipBlock", "compared", "metrics_frame", "signed", "slip_blocks", "supported", "verdicts"]
