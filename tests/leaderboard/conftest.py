"""Synthetic records for the tests: one valid record, any part of it replaced by keyword."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from leaderboard.record import Identity, Metric, Provenance, Record, Status, Timing, Verdict, record_key

RecordFactory = Callable[..., Record]
MACHINE = {"cpu": "Example CPU @ 3.0 GHz", "cores": 2, "memory_gb": 8}


def build_record(
    value: float | None = 0.9,
    low: float | None = 0.85,
    high: float | None = 0.94,
    *,
    state: str = "ok",
    reason: str = "",
    n: int = 270,
    groups: int = 180,
    interval: str = "bootstrap over groups",
    us: float | None = 120.0,
    feature_us: float | None = None,
    verdict: Verdict | None = None,
    fingerprint: str = "a" * 12,
    started: str = "2026-01-02T03:04:05+00:00",
    packages: dict[str, str] | None = None,
    **identity: Any,
) -> Record:
    who = Identity.model_validate(
        {
            "task": "objects/deep/v1",
            "variant": "paper",
            "split": "random",
            "method": "svm",
            "modality": "force",
            "kind": "simulated",
            "seed": 0,
            "dataset": "press-paper",
            "dataset_hash": "d" * 64,
            "protocol_version": 1,
        }
        | identity
    )
    metrics = []
    if state == "ok" and value is not None:
        metrics = [
            Metric(
                name="accuracy",
                value=value,
                n=n,
                groups=groups,
                low=low,
                high=high,
                interval=interval if low is not None else "",
            )
        ]
    timing = Timing(threads=1, batch=27, fit_s=0.2, predict_us_per_sample=us, feature_us_per_sample=feature_us)
    return Record(
        key=record_key(who),
        identity=who,
        status=Status.model_validate({"state": state, "reason": reason}),
        metrics=tuple(metrics),
        timing=timing if state == "ok" else None,
        verdict=verdict,
        provenance=Provenance.model_validate(
            {
                "version": "0.1.0",
                "commit": "0123abc",
                "python": "3.11.7",
                "packages": packages or {"numpy": "2.0.0"},
                "machine": MACHINE,
                "fingerprint": fingerprint,
                "started": started,
                "finished": started,
            }
        ),
    )


@pytest.fixture(scope="session")
def make_record() -> RecordFactory:
    return build_record
