"""What the intervals really cover, by simulation: `python -m leaderboard.coverage [repetitions]`.

Groups differ in difficulty as a beta distribution says whose intraclass correlation is `alike`; samples within a group
are independent given it. Nominal 95 % must cover 93 to 97 %, or the interval must carry its warning.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from leaderboard.caution import coverage_warning
from leaderboard.groups import Groups
from leaderboard.statistics import Interval, difference_of, interval_of

LOW, HIGH = 93.0, 97.0
GROUPS = ((3, 324), (5, 60), (6, 270), (10, 27), (27, 10), (270, 1), (270, 4))
"""Groups and samples in each: units, grip settings, sessions, objects, presses, presses drawn again."""
ACCURACIES = (0.8, 0.95, 0.99)
ALIKE = (0.01, 0.05, 0.2)
GAPS = (0.01, 0.1)


@dataclass(frozen=True)
class Setting:
    """One simulated experiment: an accuracy; with a `gap`, the difference to a method that misses so many hits more."""

    groups: int
    size: int
    accuracy: float
    alike: float
    gap: float = 0.0

    @property
    def truth(self) -> float:
        """What the interval must hold."""
        return self.gap * self.accuracy if self.gap else self.accuracy


@dataclass(frozen=True)
class Coverage:
    """Percent of intervals that hold the truth, that carry a warning, and the commonest way they were made."""

    setting: Setting
    covered: float
    warned: float
    method: str

    @property
    def honest(self) -> bool:
        """Whether coverage lies within its bounds, or most intervals say that it may not."""
        return LOW <= self.covered <= HIGH or self.warned > 50


def settings() -> Iterator[Setting]:
    """Every experiment of the table; single samples have no correlation within their group."""
    for (groups, size), alike in product(GROUPS, ALIKE):
        if size > 1 or alike == ALIKE[0]:
            yield from (Setting(groups, size, accuracy, alike) for accuracy in ACCURACIES)
    for (groups, size), alike, gap in product(GROUPS, ALIKE, GAPS):
        if size > 1 or alike == ALIKE[0]:
            yield Setting(groups, size, 0.95, alike, gap)


def coverage(setting: Setting, repeats: int, seed: int = 0) -> Coverage:
    """Return what nominal 95 % covers in `repeats` simulated experiments."""
    rng = np.random.default_rng([seed, setting.groups, setting.size, round(1000 * setting.accuracy)])
    intervals = [draw(setting, rng, seed=k) for k in range(repeats)]
    inside = sum(i.low <= setting.truth <= i.high for i in intervals)
    warned = sum(bool(coverage_warning(i.method, i.groups, i.value, difference=setting.gap > 0)) for i in intervals)
    methods = [i.method for i in intervals]
    return Coverage(setting, 100 * inside / repeats, 100 * warned / repeats, max(set(methods), key=methods.count))


def draw(setting: Setting, rng: np.random.Generator, seed: int) -> Interval:
    """Return the interval of one simulated experiment."""
    hits = simulate(setting.groups, setting.size, setting.accuracy, setting.alike, rng)
    if setting.gap:  # what the second method misses of the first one's hits is unlike from group to group, too
        hits &= simulate(setting.groups, setting.size, setting.gap, setting.alike, rng)
    sums = Groups(hits.sum(axis=1).astype(np.float64), np.full(setting.groups, float(setting.size)))
    return difference_of(sums, seed=seed) if setting.gap else interval_of(sums, seed=seed)


def simulate(groups: int, size: int, accuracy: float, alike: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return hits (groups, size) of a method whose groups have intraclass correlation `alike`."""
    shape = 1 / alike - 1
    easy = rng.beta(accuracy * shape, (1 - accuracy) * shape, groups)
    return rng.random((groups, size)) < easy[:, None]


def main(repeats: int = 1000) -> int:
    """Print the table and return how many settings are neither within the bounds nor warned of."""
    print(f"Nominal 95 %, {repeats} simulated experiments each; * outside {LOW:g} to {HIGH:g} %.\n")
    print(
        f"{'what':<8} {'groups':>6} {'samples':>7} {'accuracy':>8} {'alike':>5} {'covered':>8}  {'warned':>6}  method"
    )
    wrong = 0
    for setting in settings():
        got = coverage(setting, repeats)
        wrong += not got.honest
        mark = " " if LOW <= got.covered <= HIGH else "*"
        print(
            f"{f'gap {setting.gap:g}' if setting.gap else 'accuracy':<8} {setting.groups:>6} {setting.size:>7} "
            f"{setting.accuracy:>8.2f} {setting.alike:>5.2f} {got.covered:>6.1f} %{mark} "
            f"{got.warned:>5.0f} %  {got.method}",
            flush=True,
        )
    print(f"\n{wrong} settings lie outside and do not carry the warning.")
    return wrong


def _repeats(argv: Sequence[str] | None = None) -> int:
    """The number on the command line."""
    parser = ArgumentParser(prog="python -m leaderboard.coverage", description="What the intervals really cover.")
    parser.add_argument("repetitions", nargs="?", type=int, default=1000, help="of each setting (default 1000)")
    repeats = int(parser.parse_args(argv).repetitions)
    if repeats < 1:
        parser.error(f"expected at least 1 repetition, got {repeats}")
    return repeats


if __name__ == "__main__":
    sys.exit(1 if main(_repeats()) else 0)
