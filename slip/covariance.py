"""The covariance detector of the FVSight paper (its equations 12 to 15), on the time and on the taxel side.

With the last n differences as the rows of chi (n x taxels), phi = chi chi^T = tau + eps, tau diagonal; the score is
||eps||_inf, the largest absolute row sum off the diagonal. Independent differences leave eps small, differences
that repeat a pattern do not. The taxel side takes chi^T chi instead.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from slip.detector import DifferenceDetector, Stream
from slip.differences import CommonMode
from slip.gram_narrow import narrow_scores
from slip.gram_stream import TaxelGram, TimeGram
from slip.gram_wide import wide_scores
from slip.samples import Floats, Missing, as_sequence
from slip.windows import check_window, pad_front, window_sum

Side = Literal["time", "taxel"]
WIDEST_NARROW_WINDOW = 256


class Covariance(DifferenceDetector):
    """||eps||_inf over the last `window` differences, in N^2 (dimensionless where whitened or a ratio).

    See `DifferenceDetector` for the other parameters; `side` is "time" (the paper) or "taxel".
    """

    def __init__(
        self,
        window: int = 50,
        *,
        side: Side = "time",
        common_mode: CommonMode = "keep",
        scale: ArrayLike | None = None,
        nan: Missing = "refuse",
    ) -> None:
        if side not in ("time", "taxel"):
            raise ValueError(f'expected side to be "time" or "taxel", got {side!r}')
        self.side: Side = side
        super().__init__(window, common_mode=common_mode, scale=scale, nan=nan)

    def _start(self, taxels: int) -> Stream:
        return TimeGram(self.window, taxels) if self.side == "time" else TaxelGram(self.window, taxels)

    def _score_differences(self, differences: Floats) -> Floats:
        if self.side == "taxel":
            return taxel_scores(differences, self.window)
        if self.window <= WIDEST_NARROW_WINDOW:
            return narrow_scores(differences, self.window)
        return wide_scores(differences, self.window)


def covariance_norm(force: ArrayLike, window: int = 50, side: Side = "time") -> Floats:
    """Score ||eps||_inf of each sample of a force sequence; (T, taxels) newtons -> (T,) N^2.

    Raises ValueError for a wrong shape, non-finite readings or a window below 2.
    """
    return Covariance(window, side=side).score(force)


def plain_norm(force: ArrayLike, window: int = 50) -> Floats:
    """`covariance_norm` word for word, each window's matrix formed anew: the reference to compare with.

    O(T window^2 taxels); the same padding and errors.
    """
    values, _ = as_sequence(force)
    padded = np.concatenate([np.repeat(values[:1], check_window(window), axis=0), values])
    scores = np.empty(len(values))
    for t in range(len(values)):
        chi = np.diff(padded[t : t + window + 1], axis=0)
        phi = chi @ chi.T
        scores[t] = np.linalg.norm(phi - np.diag(np.diag(phi)), np.inf)
    return scores


def taxel_scores(differences: Floats, window: int) -> Floats:
    """Largest absolute off-diagonal row sum of chi^T chi for every window; (T, taxels) -> (T,).

    Pair by pair of taxels, so memory stays at a few sequences of one channel per taxel.
    """
    samples, taxels = differences.shape
    length = max(8_192, 4 * window)
    channels = np.ascontiguousarray(pad_front(differences, window - 1).T)
    scores = np.empty(samples)
    for first in range(0, samples, length):
        block = channels[:, first : first + length + window - 1]
        sums = np.zeros((taxels, block.shape[1] - window + 1))
        for a in range(taxels):
            for b in range(a):
                cross = window_sum(block[a] * block[b], window)
                np.abs(cross, out=cross)
                sums[a] += cross
                sums[b] += cross
        sums.max(axis=0, out=scores[first : first + length])
    return scores
