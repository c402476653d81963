"""The FVSight paper's per-trial table (its Table IV)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slip.alarms import AlarmRule, Trial, quiet_peaks
from slip.delay import onset_delay


@dataclass(frozen=True)
class TableRow:
    """One object of the table: slips called slip, and trials with a false alarm at rest, out of so many."""

    group: str
    slips: int
    slips_called: int
    quiet_trials: int
    quiet_called: int

    @property
    def accuracy(self) -> float:
        """Share of the slips called slip, as the paper prints it; NaN without slips."""
        return self.slips_called / self.slips if self.slips else float("nan")


def trial_table(trials: Sequence[Trial], beta: float, rule: AlarmRule | None = None) -> list[TableRow]:
    """Count by group, in the order they come; a slip is called where an alarm is raised within it.

    The paper counts slip trials alone; the trials whose quiet time holds a false alarm stand beside them.
    """
    rule = rule or AlarmRule()
    rows: list[TableRow] = []
    for group in dict.fromkeys(trial.group for trial in trials):
        mine = [trial for trial in trials if trial.group == group]
        slips = [trial for trial in mine if trial.onset is not None]
        quiet = [peaks for peaks, minutes in (quiet_peaks(trial, rule) for trial in mine) if minutes > 0.0]
        rows.append(
            TableRow(
                group,
                len(slips),
                sum(bool(np.isfinite(onset_delay(trial, beta, rule))) for trial in slips),
                len(quiet),
                sum(bool((peaks >= beta).any()) for peaks in quiet),
            )
        )
    return rows
