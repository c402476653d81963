"""What every slip detector offers, and the part that all of them share: from force samples to differences."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slip.differences import COMMON_MODES, CommonMode, treat
from slip.samples import Floats, Missing, SampleClock, as_sample, as_sequence, check_regular
from slip.windows import check_window


@runtime_checkable
class Detector(Protocol):
    """A slip score from taxel forces: a sample at a time, or a whole sequence; both give the same scores."""

    def reset(self) -> None:
        """Forget every sample."""

    def update(self, sample: ArrayLike) -> float:
        """Take one sample (taxels,) in newtons; return the score at it."""

    def score(self, sequence: ArrayLike) -> Floats:
        """Score each sample of (T, taxels) newtons as a fresh stream would; (T,). Leaves the stream alone."""


class Stream(Protocol):
    """The running state of one detector over treated differences."""

    def push(self, difference: Floats) -> float:
        """Take the next difference (taxels,); return the score."""


class DifferenceDetector(ABC):
    """A detector that works on the last `window` force differences.

    Parameters
    ----------
    window : number of differences, at least 2. Before that many came, the missing ones count as zero: the
        array is taken to have rested. The first sample has no difference and scores as a zero one.
    common_mode : "keep" (the paper), "mean", "load" or "ratio", see `slip.differences`.
    scale : (taxels,) newtons or None; treated differences are divided by it (rest noise, to whiten the taxels).
    nan : "refuse" raises ValueError on a missing sample; "skip" leaves the sample out as if it had never
        been taken, repeats the last score there (0 before any) and counts it in `skipped`.

    """

    def __init__(
        self,
        window: int = 50,
        *,
        common_mode: CommonMode = "keep",
        scale: ArrayLike | None = None,
        nan: Missing = "refuse",
    ) -> None:
        if common_mode not in COMMON_MODES:
            raise ValueError(f"expected common_mode to be one of {COMMON_MODES}, got {common_mode!r}")
        if nan not in ("refuse", "skip"):
            raise ValueError(f'expected nan to be "refuse" or "skip", got {nan!r}')
        self.window = check_window(window)
        self.common_mode: CommonMode = common_mode
        self.scale = None if scale is None else _checked_scale(scale)
        self.nan: Missing = nan
        self.reset()

    def reset(self) -> None:
        """Forget every sample and the count of skipped ones."""
        self.skipped = 0
        self._previous: Floats | None = None
        self._stream: Stream | None = None
        self._clock = SampleClock()
        self._last = 0.0

    def with_scale(self, scale: ArrayLike) -> Self:
        """Return a reset detector of the same kind whose differences are divided by `scale` (taxels,)."""
        other = copy.copy(self)
        other.scale = _checked_scale(scale)
        other.reset()
        return other

    @property
    def settling(self) -> int:
        """Samples after a start or a spike until the score depends on what came since only."""
        return self.window + 1

    def update(self, sample: ArrayLike, time_s: float | None = None) -> float:
        """Take one sample (taxels,) in newtons, with its time where known; return the score at it.

        Raises ValueError for a wrong shape, a non-finite reading (see `nan`) or an irregular time step.
        """
        taxels = None if self._previous is None else self._previous.shape[1]
        values = as_sample(sample, taxels, self.nan)
        if time_s is not None:
            self._clock.tick(time_s)
        if values is None:
            self.skipped += 1
            return self._last
        now = values[None]
        if self._stream is None or self._previous is None:
            self._check_taxels(len(values))
            self._stream, self._previous = self._start(len(values)), now
        self._last = self._stream.push(self._treated(now - self._previous, self._previous)[0])
        self._previous = now
        return self._last

    def score(self, sequence: ArrayLike, time_s: ArrayLike | None = None) -> Floats:
        """Score each sample of (T, taxels) newtons as a fresh stream would; (T,).

        The stream's state is left alone; samples that are skipped add to `skipped`. Raises ValueError for a
        wrong shape, non-finite readings (see `nan`) or, where times are given, irregular sampling.
        """
        force, kept = self._checked(sequence, time_s)
        return self._spread(self._score_kept(force), kept)

    def _checked(self, sequence: ArrayLike, time_s: ArrayLike | None) -> tuple[Floats, NDArray[np.bool_]]:
        """Return the samples that are kept and the mask of them; those that are skipped are counted."""
        force, kept = as_sequence(sequence, self.nan)
        self._check_taxels(force.shape[1])
        if time_s is not None:
            check_regular(time_s, len(force))
        if kept.all():
            return force, kept
        self.skipped += int((~kept).sum())
        return force[kept], kept

    @staticmethod
    def _spread(scores: Floats, kept: NDArray[np.bool_]) -> Floats:
        """Repeat the last score at each sample that was skipped, 0 before any."""
        return scores if kept.all() else np.concatenate([[0.0], scores])[np.cumsum(kept)]

    def _score_kept(self, force: Floats) -> Floats:
        if len(force) == 0:
            return np.zeros(0)
        return self._score_differences(self.treated_differences(force))

    def treated_differences(self, force: Floats) -> Floats:
        """Difference finite forces (T, taxels), treat the common mode, divide by the scale; first row 0."""
        differences = np.empty(force.shape)
        differences[:1] = 0.0
        np.subtract(force[1:], force[:-1], out=differences[1:])
        if self.common_mode != "keep" or self.scale is not None:
            differences[1:] = self._treated(differences[1:], force[:-1])
        return differences

    def _treated(self, differences: Floats, previous: Floats) -> Floats:
        treated = treat(differences, previous, self.common_mode)
        return treated if self.scale is None else treated / self.scale

    def _check_taxels(self, taxels: int) -> None:
        if self.scale is not None and len(self.scale) != taxels:
            raise ValueError(f"expected {len(self.scale)} taxels, as many as in `scale`, got {taxels}")

    @abstractmethod
    def _start(self, taxels: int) -> Stream:
        """Return the state of a stream that has seen nothing."""

    @abstractmethod
    def _score_differences(self, differences: Floats) -> Floats:
        """Score treated differences (T, taxels) as a fresh stream would; (T,)."""


def _checked_scale(scale: ArrayLike) -> Floats:
    values = np.array(scale, dtype=np.float64)
    if values.ndim != 1 or not (np.isfinite(values).all() and (values > 0.0).all()):
        raise ValueError("expected a finite positive scale in newtons for each taxel, shape (taxels,)")
    return values
