"""What a run did, for the caller and the command line."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from leaderboard.record import Record


@dataclass(frozen=True)
class RunSummary:
    """Cells of a run, by what became of them.

    Attributes:
        path: folder of the run.
        total: cells of the suite.
        done: cells that were run, or scored again, now.
        kept: cells that had their record already.
        skipped, failed, timeout: records of that state, whether new or kept.
        seconds: wall time.
        records: records of all cells.
    """

    path: Path
    total: int
    done: int
    kept: int
    skipped: int
    failed: int
    timeout: int
    seconds: float
    records: tuple[Record, ...]

    @classmethod
    def of(cls, path: Path, records: list[Record], done: int, seconds: float) -> RunSummary:
        """Count the records' states."""
        states = Counter(record.status.state for record in records)
        return cls(
            path=path,
            total=len(records),
            done=done,
            kept=len(records) - done,
            skipped=states["skipped"],
            failed=states["failed"],
            timeout=states["timeout"],
            seconds=seconds,
            records=tuple(records),
        )

    @property
    def broken_laws(self) -> tuple[Record, ...]:
        """Records of laws that did not hold."""
        return tuple(r for r in self.records if r.verdict is not None and not r.verdict.passed)

    def lines(self) -> list[str]:
        """What to print: one line, and one for each thing that went wrong or is missing."""
        if self.done:
            first = f"{self.path}: {self.done} of {self.total} cells run in {self.seconds:.1f} s"
            first += f", {self.kept} kept from before" if self.kept else ""
        else:
            first = f"{self.path}: all {self.total} cells are there, nothing to do ({self.seconds:.1f} s)"
        lines = [first]
        reasons = Counter((r.status.state, r.status.reason) for r in self.records if r.status.state != "ok")
        for (state, reason), count in reasons.items():
            lines.append(f"{state}: {count} cell{'s' if count > 1 else ''}: {reason}")
        if self.failed or self.timeout:
            lines.append("cells that failed keep their row; --fresh runs everything again")
        laws = [r for r in self.records if r.verdict is not None]
        if laws:
            lines.append(f"laws: {len(laws) - len(self.broken_laws)} of {len(laws)} hold")
        for record in self.broken_laws:
            assert record.verdict is not None
            i, v = record.identity, record.verdict
            lines.append(f"law broken: {v.law}: {i.method} on {i.modality}: {v.observed}, expected {v.expected}")
        return lines
