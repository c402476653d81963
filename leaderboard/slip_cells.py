"""Cells of the slip tables: shares, delays, differences to the baseline."""

from __future__ import annotations

from collections.abc import Sequence

from leaderboard.names import METHODS, MODALITIES, title
from leaderboard.record import Metric, Record
from leaderboard.sections import STANDINGS, standing_shown
from leaderboard.slip_tables import BASELINE, BOTH_MISS, SlipBlock, compared, signed
from leaderboard.slips import MISSED_MS, metric
from leaderboard.views import NOT_RUN, Cell, breaks_of, brief, microseconds, number, span


def who_cells(record: Record) -> tuple[Cell, Cell]:
    """Threshold rule and detector; one that was handed in by its title and standing."""
    method, given = record.identity.method, record.submission
    rule = Cell(title(MODALITIES, record.identity.modality))
    if given is not None:
        standing = standing_shown(given.status, record.status.state == "ok")
        return rule, Cell(brief(given.title, 60), badge=standing, hint=STANDINGS[standing])
    return rule, Cell(title(METHODS, method), "the baseline" if method == BASELINE else "")


def rule_breaks(records: Sequence[Record]) -> frozenset[int]:
    """Rows at which another threshold rule begins."""
    return breaks_of([record.identity.modality for record in records])


def dataset_note(block: SlipBlock) -> tuple[str, ...]:
    """Which trials."""
    return (f"Dataset {block.dataset}, content {block.dataset_hash[:12]}.",)


def words(name: str) -> str:
    """A name as a heading."""
    return name[:1].upper() + name[1:].replace("_", " ")


def count_cell(found: Metric | None) -> Cell:
    """A share as `19/20` with its interval in percent."""
    if found is None:
        return Cell(NOT_RUN, tone="muted")
    detail = f"{100 * found.value:.0f} %"
    if found.low is not None and found.high is not None:
        detail += f", {span(100 * found.low, 100 * found.high)}"
    return Cell(f"{found.value * found.n:.0f}/{found.n}", detail, found.value)


def percent_cell(found: Metric | None) -> Cell:
    """A share in percent with its interval."""
    if found is None or found.low is None or found.high is None:
        return Cell(NOT_RUN, tone="muted")
    return Cell(number(100 * found.value), span(100 * found.low, 100 * found.high), 100 * found.value)


def plain_cell(found: Metric | None) -> Cell:
    """A figure in its own unit with its interval."""
    if found is None:
        return Cell(NOT_RUN, tone="muted")
    return Cell(number(found.value, 2), span(found.low, found.high, 2), found.value, hint=found.interval)


def area_cell(found: Metric | None) -> Cell:
    """An area with its interval."""
    if found is None:
        return Cell(NOT_RUN, tone="muted")
    return Cell(number(found.value, 3), span(found.low, found.high, 3), found.value)


def cost_cell(found: Metric | None) -> Cell:
    """Microseconds a sample."""
    value = None if found is None else found.value
    return Cell(microseconds(value), sort=value)


def delay_text(ms: float) -> str:
    """A delay in milliseconds; infinite where most slips are missed."""
    return "∞" if ms >= MISSED_MS / 2 else f"{ms:,.0f}".replace("-", "−")


def delay_cell(found: Metric | None, key: str) -> Cell:
    """A median delay with its interval."""
    if found is None or found.low is None or found.high is None:
        return Cell(NOT_RUN, tone="muted")
    return Cell(delay_text(found.value), f"{delay_text(found.low)} to {delay_text(found.high)}", found.value, key=key)


def difference_cell(record: Record, rate: float, factor: str = "", value: str = "") -> Cell:
    """The median delay less the baseline's; good where earlier, bad where later, by the paired interval."""
    found = metric(record, "delay_minus_energy_ms", rate, factor, value)
    if found is None or found.low is None or found.high is None:
        return Cell(NOT_RUN, tone="muted")
    if record.identity.method == BASELINE:
        return Cell("0", sort=0.0, tone="muted")
    judged = compared(record, rate, factor, value)
    if judged == BOTH_MISS:
        return Cell("–", hint=judged, tone="muted")
    detail = f"{signed(found.low)} to {signed(found.high)}"
    if judged == "earlier":
        return Cell(signed(found.value), detail, found.value, tone="good")
    return Cell(signed(found.value), detail, found.value, tone="bad" if judged == "later" else "")


def both_cell(delay: Metric | None, found: Metric | None) -> Cell:
    """A median delay with the slips found."""
    if delay is None or found is None:
        return Cell(NOT_RUN, tone="muted")
    return Cell(delay_text(delay.value), f"{found.value * found.n:.0f}/{found.n}", delay.value)
