"""What a cell got right, summed by group: enough to compare it with another cell, small enough to keep and to commit.

Beside a record as `runs/<key>/tally.json`. Truth is not in it: from it nobody learns the label of a sample.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from leaderboard._files import TALLY_FILE, write_atomic
from leaderboard.groups import Groups, grouped


class Tally(BaseModel):
    """Sums of scores and counts of predictions by group, groups in sorted order.

    `samples` is a hash of which samples were predicted in which fold: cells with equal ones are paired.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    samples: str = Field(min_length=1)
    total: tuple[float, ...] = Field(min_length=1)
    size: tuple[int, ...]

    @model_validator(mode="after")
    def _aligned(self) -> Tally:
        if len(self.total) != len(self.size):
            raise ValueError(f"expected a sum and a count for each group, got {len(self.total)} and {len(self.size)}")
        for total, size in zip(self.total, self.size, strict=True):
            if size < 1 or not 0 <= total <= size:
                raise ValueError(f"expected a sum between 0 and its count, got {total:g} of {size}")
        return self

    @property
    def groups(self) -> Groups:
        """The sums as arrays."""
        return Groups(np.array(self.total, dtype=np.float64), np.array(self.size, dtype=np.float64))


def tally(correct: ArrayLike, groups: ArrayLike, sample_ids: ArrayLike, folds: ArrayLike) -> Tally:
    """Return the tally of scores in 0..1; all four are (n,), a row a prediction, in any order."""
    scores = np.asarray(correct, dtype=np.float64)
    labels, ids, fold = (np.asarray(a).astype(str) for a in (groups, sample_ids, folds))
    sums = grouped(scores, labels)
    rows = sorted(zip(labels.tolist(), ids.tolist(), fold.tolist(), strict=True))
    samples = hashlib.sha256(json.dumps(rows, separators=(",", ":")).encode()).hexdigest()[:16]
    total = [float(round(value, 9)) for value in sums.total]
    return Tally(samples=samples, total=tuple(total), size=tuple(int(value) for value in sums.size))


def write_tally(folder: Path, value: Tally) -> None:
    """Write a tally into the folder of its record, whole."""
    write_atomic(folder / TALLY_FILE, (json.dumps(plain(value), separators=(",", ":")) + "\n").encode())


def plain(value: Tally) -> dict[str, object]:
    """Return a tally as JSON values, whole sums without a decimal point."""
    total = [int(v) if v == int(v) else v for v in value.total]
    return {"samples": value.samples, "total": total, "size": list(value.size)}


def read_tallies(run_dir: Path) -> dict[str, Tally]:
    """Return the tallies under `run_dir` (or its `runs`) by the key of their record; broken ones are left out."""
    root = run_dir / "runs" if (run_dir / "runs").is_dir() else run_dir
    found: dict[str, Tally] = {}
    for path in sorted(root.glob(f"*/{TALLY_FILE}")):
        try:
            found[path.parent.name] = Tally.model_validate_json(path.read_bytes())
        except (ValidationError, OSError):
            continue
    return found


Tallies = Mapping[str, Tally]
"""Key of a record -> its tally."""
