"""Records for the page of the browser test: two splits, probes, submissions of every standing, real and simulated."""

from __future__ import annotations

import numpy as np

from leaderboard.record import Record
from leaderboard.statistics import group_interval
from leaderboard.submission import Submission
from leaderboard.tally import Tally, tally

HOSTILE = "<img src=x onerror=alert(1)>\"'><script>alert(2)</script>"
METHODS = {"ksc": (0.93, 60.0), "knn": (0.90, 12.0), "svm": (0.95, 25.0), "slow-and-poor": (0.5, 900.0)}


def suite(make_record) -> tuple[list[Record], dict[str, Tally]]:
    """Return records and tallies; what a method gets right is drawn, so that intervals and ranks are real."""
    records: list[Record] = []
    tallies: dict[str, Tally] = {}
    groups = np.repeat(np.arange(60), 5)
    ids, folds = np.arange(300).astype(str), np.zeros(300)

    def add(seed: int, rate: float, **identity) -> None:
        correct = np.random.default_rng(seed).random(300) < rate
        got = group_interval(correct, groups)
        record = make_record(got.value, got.low, got.high, n=300, groups=60, interval=got.method, **identity)
        records.append(record)
        tallies[record.key] = tally(correct, groups, ids, folds)

    for split, loss in (("random", 0.0), ("held-out-unit", 0.2)):
        for at, (method, (rate, us)) in enumerate(METHODS.items()):
            for modality, feature_us in (("force", None), ("image", 8000.0)):
                add(at, rate - loss, method=method, us=us, modality=modality, feature_us=feature_us, split=split)
    add(7, 0.94, role="probe", modality="total-force")
    for at, (method, (rate, us)) in enumerate(METHODS.items()):
        for kind, task in (("simulated", "texture/slides/v1"), ("real", "texture/fabricslide16/v1")):
            add(20 + at, rate, method=method, us=us, task=task, kind=kind, variant="public", modality="spectrum")
    for status in ("verified", "self-reported", "flagged"):
        record = make_record(0.97, 0.95, 0.99, method=f"sub-{status}", variant="default")
        given = Submission(
            id=f"sub-{status}",
            title=f"Net of {status} origin & co",
            status=status,
            reason=HOSTILE if status == "flagged" else "",
            authors=("A. Author",),
            link="https://example.org/net",
        )
        records.append(record.model_copy(update={"submission": given}))
    records.append(make_record(method=HOSTILE, modality=HOSTILE, variant=HOSTILE, dataset=HOSTILE, params={HOSTILE: 1}))
    records.append(make_record(state="failed", reason=HOSTILE, method="broken", variant="default"))
    return records, tallies
