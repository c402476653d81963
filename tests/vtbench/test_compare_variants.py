"""`vtbench compare --from`: what each method loses from one variant to another, paired with itself."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from leaderboard.baselines import read_baselines
from leaderboard.record import record_key, write_record
from leaderboard.tally import tally, write_tally

PRESSES = 200
SHARES = {  # method -> variant -> share of presses named rightly, the easiest first
    "jksc": {"clean": 0.9, "no-image": 0.5, "no-force": 0.9},
    "svm": {"clean": 0.95, "no-image": 0.05},
}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two methods on 200 presses each, one of them never without force."""
    template = next(r for r in read_baselines()[0] if r.status.state == "ok" and r.identity.role == "method")
    folder = tmp_path_factory.mktemp("faults")
    for method, levels in SHARES.items():
        for variant, share in levels.items():
            who = {"task": "robustness/v1", "variant": variant, "method": method, "modality": "fused-change-equal"}
            identity = template.identity.model_copy(update={**who, "split": "random", "params": {}})
            metric = template.metrics[0].model_copy(
                update={"value": share, "low": max(0.0, share - 0.05), "high": min(1.0, share + 0.05)}
            )
            made = {"identity": identity, "key": record_key(identity), "metrics": (metric,)}
            right = np.arange(PRESSES) < round(share * PRESSES)
            counted = tally(right, np.arange(PRESSES), np.arange(PRESSES), np.zeros(PRESSES))
            write_tally(write_record(folder, template.model_copy(update=made)), counted)
    return folder


def test_the_loss_is_the_methods_own_and_paired(run, vtbench):
    rows = json.loads(vtbench("compare", run, "--from", "clean", "--json").out)["rows"]
    found = {(row["method"], row["variant"]): row for row in rows}
    assert set(found) == {("jksc", "no-image"), ("jksc", "no-force"), ("svm", "no-image")}
    for (method, variant), row in found.items():
        assert row["paired"]
        assert row["difference"] == pytest.approx(SHARES[method][variant] - SHARES[method]["clean"])
        assert row["low"] <= row["difference"] <= row["high"]
    assert found["jksc", "no-image"]["verdict"] == "worse"
    assert found["jksc", "no-force"]["verdict"] == "the same"
    back = json.loads(
        vtbench("compare", run, "--from", "no-image", "--methods", "svm@fused-change-equal", "--json").out
    )
    (row,) = back["rows"]
    assert row["verdict"] == "better"
    assert row["difference"] == pytest.approx(-found["svm", "no-image"]["difference"])


def test_the_table_has_a_block_for_each_variant_the_best_first(run, vtbench):
    text = vtbench("compare", run, "--from", "clean").out
    block = text.split("from clean to no-image")[1]
    assert block.index("jksc@fused-change-equal") < block.index("svm@fused-change-equal")
    assert "from clean to no-force" in text
    assert "-40.0" in block
    assert "-90.0" in block


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--from", "cleen"], "no scored method on variant 'cleen'; there is clean, no-force, no-image"),
        (["--from", "no-force", "--methods", "svm@fused-change-equal"], "no method was scored on 'no-force' and on"),
        (["--from", "clean", "--paper"], "leave --paper and a second run out"),
        (["--from", "clean", "--methods", "nobody"], "no scored method 'nobody'"),
    ],
)
def test_what_cannot_be_compared_is_one_line(run, vtbench, arguments, said):
    answer = vtbench("compare", run, *arguments)
    assert answer.code == 2
    assert said in answer.err
    assert answer.err.count("\n") == 1
