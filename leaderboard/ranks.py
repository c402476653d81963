"""Ranks that say what is known: for each method the ranks it may hold, and letters that tied methods share.

Source: Mohamad, Goeman and van Zwet, Biometrical Journal 61 (2019), ranks from simultaneous pairwise tests; Piepho,
Journal of Computational and Graphical Statistics 13 (2004), letters by insertion and absorption.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from string import ascii_lowercase

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from leaderboard.groups import Groups
from leaderboard.paired import difference_p, holm

BoolArray = NDArray[np.bool_]

PAIRED = "paired over groups, Holm"
UNPAIRED = "from the intervals alone, not paired, Holm"


@dataclass(frozen=True)
class Rank:
    """A method may hold any rank `best`..`worst`, 1 first; methods that share a letter are not separated."""

    best: int
    worst: int
    letters: str

    @property
    def text(self) -> str:
        """The ranks as `1` or `2–4`."""
        return str(self.best) if self.best == self.worst else f"{self.best}–{self.worst}"


@dataclass(frozen=True)
class Entrant:
    """A method to be ranked; higher `value` is better. `groups` allow pairing; else `error` is its standard error."""

    value: float
    error: float
    groups: Groups | None = None
    samples: str = ""


@dataclass(frozen=True, eq=False)
class Ranking:
    """Ranks of the entrants in their order, `better[i, j]` where i is surely better than j, and how that was found."""

    ranks: tuple[Rank, ...]
    better: BoolArray
    how: str


def rank(entrants: Sequence[Entrant], level: float = 0.95) -> Ranking:
    """Return the rank interval of each entrant.

    All pairs are compared, by groups where all entrants were scored on the same samples, else by their standard
    errors; Holm's step-down keeps the chance of any false separation below 1 - level, so all rank intervals hold
    together with that confidence.
    """
    paired = all(e.groups is not None and e.samples == entrants[0].samples for e in entrants)
    pairs = list(combinations(range(len(entrants)), 2))
    p = holm([_pair_p(entrants[i], entrants[j], paired) for i, j in pairs])
    better = np.zeros((len(entrants), len(entrants)), dtype=bool)
    for (i, j), adjusted in zip(pairs, p, strict=True):
        if adjusted <= 1 - level:
            first, second = (i, j) if entrants[i].value > entrants[j].value else (j, i)
            better[first, second] = True
    order = sorted(range(len(entrants)), key=lambda i: -entrants[i].value)
    shared = tie_letters(better | better.T, order)
    count = len(entrants)
    ranks = [
        Rank(1 + int(better[:, i].sum()), count - int(better[i].sum()), letters) for i, letters in enumerate(shared)
    ]
    return Ranking(tuple(ranks), better, PAIRED if paired else UNPAIRED)


def _pair_p(a: Entrant, b: Entrant, paired: bool) -> float:
    if paired and a.groups is not None and b.groups is not None:
        return difference_p(a.groups.minus(b.groups))
    error = float(np.hypot(a.error, b.error))
    return float(2 * ndtr(-abs(a.value - b.value) / error)) if error > 0 else float(a.value == b.value)


def tie_letters(separated: BoolArray, order: Sequence[int]) -> list[str]:
    """Return for each method its letters: two share one exactly where they are not `separated` (m, m)."""
    columns: list[frozenset[int]] = [frozenset(order)]
    for i, j in combinations(order, 2):
        if not separated[i, j]:
            continue
        split = [part for column in columns if i in column and j in column for part in (column - {i}, column - {j})]
        columns = [column for column in columns if not (i in column and j in column)]
        for part in split:
            if not any(part <= other for other in columns):
                columns = [other for other in columns if not other <= part] + [part]
    place = {method: at for at, method in enumerate(order)}
    columns.sort(key=lambda column: sorted(place[method] for method in column))
    names = [_letter(at) for at in range(len(columns))]
    return ["".join(name for name, column in zip(names, columns, strict=True) if i in column) for i in sorted(order)]


def _letter(at: int) -> str:
    return ascii_lowercase[at % 26] + ("" if at < 26 else str(at // 26 + 1))
