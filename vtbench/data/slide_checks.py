"""What can be wrong with the state and the onset of slides."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from vtbench.data.format import SLIDE_STATES

Problem = tuple[str, NDArray[np.int64]]
GROSS = SLIDE_STATES.index("gross slip")


def first_gross(state: NDArray[np.uint8]) -> int | None:
    """First sample of gross slip; None without."""
    found = np.flatnonzero(state == GROSS)
    return int(found[0]) if found.size else None


def state_problems(cells: pa.Array, table: pa.Table) -> Iterator[Problem]:
    """Rows whose state has another length than the forces, or an unknown value."""
    values = cells.flatten().to_numpy()
    lengths = cells.value_lengths().to_numpy()
    row = np.repeat(np.arange(len(cells)), lengths)
    yield f"a state outside 0..{len(SLIDE_STATES) - 1}", np.unique(row[values >= len(SLIDE_STATES)])
    if "force_series" in table.column_names:
        samples = pc.list_value_length(table["force_series"]).to_numpy()
        yield "not one state for each sample of force_series", np.flatnonzero(lengths != samples)


def onset_problems(cells: pa.Array, table: pa.Table) -> Iterator[Problem]:
    """Rows whose onset is not the first sample of gross slip in their state; a missing one means no gross slip."""
    if "state" not in table.column_names or table["state"].null_count:
        return
    states = table["state"].combine_chunks()
    wrong = [
        row
        for row, onset in enumerate(cells.to_pylist())
        if first_gross(states[row].values.to_numpy(zero_copy_only=False)) != onset
    ]
    yield "not the first sample of gross slip in `state`", np.array(wrong, np.int64)
