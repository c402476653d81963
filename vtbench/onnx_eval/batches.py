"""Samples on disk -> batches -> what a model gives for them; the part that runs beside the model.

A sample may be a row of an array or, in time, a piece of its own length. Scores of all samples stand below each other:
(samples, classes), or for scores in time (sum of lengths, 1).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Call = Callable[[dict[str, Any]], Any]
Scores = NDArray[np.float32]

WARM_UP = 2
MOST_CALLS, FEWEST_CALLS = 60, 3


@dataclass(frozen=True)
class Inputs:
    """Arrays by input name; `starts` (samples + 1,) where those in time begin."""

    arrays: Mapping[str, NDArray[Any]]
    starts: NDArray[np.int64] | None

    @classmethod
    def open(cls, folder: Path, inputs: Sequence[Mapping[str, Any]]) -> Inputs:
        """Map the files that `write` left in `folder`."""
        arrays = {
            each["name"]: np.memmap(folder / f"{each['name']}.raw", each["dtype"], "r", shape=tuple(each["shape"]))
            for each in inputs
        }
        starts = folder / "starts.raw"
        return cls(arrays, np.fromfile(starts, np.int64) if starts.exists() else None)

    def take(self, names: Sequence[str], samples: Sequence[int]) -> dict[str, NDArray[Any]]:
        """Inputs of a batch; pieces in time must be of one length."""
        return {name: self._rows(name, samples) for name in names}

    def length(self, sample: int) -> int:
        """Scores that a sample has: its length in time, else one."""
        return 1 if self.starts is None else int(self.starts[sample + 1] - self.starts[sample])

    def _rows(self, name: str, samples: Sequence[int]) -> NDArray[Any]:
        array = self.arrays[name]
        if name != "force_series" or self.starts is None:
            return np.ascontiguousarray(array[np.asarray(samples)])
        return np.stack([array[self.starts[each] : self.starts[each + 1]] for each in samples])


class OutputError(ValueError):
    """What a model gave is not what was asked for."""


def run_all(call: Call, inputs: Inputs, names: Sequence[str], batches: Sequence[Sequence[int]], width: int) -> Scores:
    """Scores of every batch below each other, in the batches' order.

    Args:
        call: the model.
        inputs: the samples.
        names: inputs that the model takes.
        batches: samples of each call.
        width: classes; 0 for scores in time.

    Raises:
        OutputError: wrong type or shape.
    """
    parts = [checked(call(inputs.take(names, batch)), _shape(inputs, batch, width)) for batch in batches]
    return np.concatenate([part.reshape(-1, max(width, 1)) for part in parts])


def checked(output: Any, shape: tuple[int, ...]) -> Scores:
    """An output that has the type and shape that it must have, or OutputError."""
    if not isinstance(output, np.ndarray) or output.dtype != np.float32:
        raise OutputError(f"the output is {getattr(output, 'dtype', type(output).__name__)}, expected float32")
    if output.shape != shape:
        raise OutputError(f"the output has shape {output.shape}, expected {shape}")
    return output


def time_calls(
    call: Call, inputs: Inputs, names: Sequence[str], batches: Sequence[Sequence[int]], budget_s: float, width: int
) -> tuple[dict[str, Any], Scores]:
    """Latency of calls on rotating batches in milliseconds, and the scores of the first round of them.

    At most `MOST_CALLS`, and no more after `budget_s` when `FEWEST_CALLS` are done; making the batch is not counted.
    """
    fed = [inputs.take(names, batch) for batch in batches]
    for at in range(WARM_UP):
        call(fed[at % len(fed)])
    started = time.perf_counter()
    spent: list[float] = []
    given: dict[int, Scores] = {}
    while len(spent) < MOST_CALLS and (
        len(spent) < max(FEWEST_CALLS, len(fed)) or time.perf_counter() - started < budget_s
    ):
        at = len(spent) % len(fed)
        before = time.perf_counter_ns()
        output = call(fed[at])
        spent.append((time.perf_counter_ns() - before) / 1e6)
        given.setdefault(at, checked(output, _shape(inputs, batches[at], width)).reshape(-1, max(width, 1)))
    low, middle, high = (_quantile(sorted(spent), share) for share in (0.0, 0.5, 0.95))
    latency = {"batch": len(batches[0]), "calls": len(spent), "min_ms": low, "p50_ms": middle, "p95_ms": high}
    return latency, np.concatenate([given[at] for at in range(len(fed))])


def _quantile(ordered: list[float], share: float) -> float:
    """The smallest value that `share` of all do not exceed; np.quantile imports as it runs, when no file opens."""
    return ordered[max(0, math.ceil(share * len(ordered)) - 1)]


def _shape(inputs: Inputs, batch: Sequence[int], width: int) -> tuple[int, ...]:
    return (len(batch), width) if width else (len(batch), inputs.length(batch[0]))
