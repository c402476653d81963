"""ROC by trial: one score per trial, never overlapping windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slip.alarms import AlarmRule, Trial, held_score
from slip.samples import Floats


@dataclass(frozen=True)
class Roc:
    """Share of slip trials caught against share of other trials that alarm, as beta falls; area with interval."""

    thresholds: Floats
    false_positive: Floats
    true_positive: Floats
    area: float
    area_interval: tuple[float, float]


def trial_peak(trial: Trial, rule: AlarmRule) -> float:
    """Largest held score within the slip, or of the whole trial where there is none."""
    held = held_score(trial, rule)
    return float(held.max() if trial.onset is None else held[trial.onset : trial.end].max())


def roc_by_trial(
    trials: Sequence[Trial],
    rule: AlarmRule | None = None,
    *,
    level: float = 0.95,
    draws: int = 1000,
    seed: int = 0,
) -> Roc:
    """Draw the ROC of trials with slip against trials without; the interval redraws trials within each kind.

    Trials of unequal length are not alike: a longer one has more chances to alarm. Raises ValueError where either
    kind is missing.
    """
    rule = rule or AlarmRule()
    slips = np.array([trial_peak(trial, rule) for trial in trials if trial.onset is not None])
    others = np.array([trial_peak(trial, rule) for trial in trials if trial.onset is None])
    if len(slips) == 0 or len(others) == 0:
        raise ValueError(f"expected trials with and without slip, got {len(slips)} with and {len(others)} without")
    thresholds = np.concatenate([[np.inf], np.unique(np.concatenate([slips, others]))[::-1]])
    rng = np.random.default_rng(seed)
    areas = [area(rng.choice(slips, len(slips)), rng.choice(others, len(others))) for _ in range(draws)]
    low, high = np.quantile(areas, [(1.0 - level) / 2.0, (1.0 + level) / 2.0])
    return Roc(
        thresholds,
        (others[None] >= thresholds[:, None]).mean(axis=1),
        (slips[None] >= thresholds[:, None]).mean(axis=1),
        area(slips, others),
        (float(low), float(high)),
    )


def area(slips: Floats, others: Floats) -> float:
    """Chance that a slip trial scores above another one, ties counted half (Mann and Whitney)."""
    above = (slips[:, None] > others[None]).mean()
    return float(above + 0.5 * (slips[:, None] == others[None]).mean())
