"""What a model gave -> scores by sample, or why they do not count; and whether they hang on order, company or clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vtbench.onnx_eval.plan import Batches
from vtbench.onnx_eval.sandbox import Answer, Job

TOLERANCE = 1e-3
"""Of the range of all scores: rounding differs with the size of a batch, by far less than this."""

Scores = NDArray[np.float32]


@dataclass(frozen=True)
class Judged:
    """Scores of each sample, (1, width) or (T, 1), or a reason why there are none; doubts that do not void them."""

    scores: list[Scores]
    reason: str = ""
    doubts: tuple[str, ...] = ()


def judge(answer: Answer, job: Job, lengths: NDArray[np.int64] | None) -> Judged:
    """Check arrays for size and finiteness, and compare what was given twice. Never believes a shape unchecked."""
    in_time = job.width == 0
    timed = [batch for plan in job.timing for batch in plan["batches"] if plan["batch"] in answer.timed]
    heard = (
        ("scores", answer.scores, list(job.batches)),
        ("scores in another order", answer.recheck, list(job.recheck)),
        ("timed scores", np.concatenate([*answer.timed.values()]) if answer.timed else None, timed),
    )
    pieces = []
    for name, values, batches in heard:
        sizes = [_rows(sample, lengths, in_time) for batch in batches for sample in batch]
        if values is None or len(values) != sum(sizes):
            return Judged([], f"its process ended with {0 if values is None else len(values)} of {sum(sizes)} {name}")
        pieces.append(_by_sample(values, batches, sizes))
    bad = {sample for piece in pieces for sample, rows in piece if not np.isfinite(rows).all()}
    if bad:
        total = len(pieces[0])
        return Judged([], f"{len(bad)} of {total} samples have scores that are not finite (NaN or infinite)")
    known = dict(pieces[0])
    scale = float(np.ptp(np.concatenate([rows.ravel() for rows in known.values()]))) or 1.0
    doubts = [
        f"{what}: {off} of {len(piece)} differ by more than {TOLERANCE:g} of the range of scores"
        for what, piece in zip(
            ("scores depend on the order or company of the samples", "timed scores are not the scored ones"),
            pieces[1:],
            strict=True,
        )
        if (off := sum(float(np.abs(rows - known[sample]).max()) > TOLERANCE * scale for sample, rows in piece))
    ]
    return Judged([known[sample] for sample in range(len(known))], doubts=tuple(doubts))


def _rows(sample: int, lengths: NDArray[np.int64] | None, in_time: bool) -> int:
    return int(lengths[sample]) if in_time and lengths is not None else 1


def _by_sample(
    values: Scores, batches: Batches | Sequence[Sequence[int]], sizes: list[int]
) -> list[tuple[int, Scores]]:
    samples = [sample for batch in batches for sample in batch]
    return list(zip(samples, np.split(values, np.cumsum(sizes)[:-1]), strict=True))
