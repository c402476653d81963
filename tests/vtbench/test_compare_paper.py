"""`vtbench compare --paper` on the records that come with the package."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from leaderboard.baselines import read_baselines
from leaderboard.names import USUAL_BACKBONE
from leaderboard.record import record_key, write_record
from leaderboard.tally import write_tally


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The records of deep presses: force, image, and both with equal weights."""
    records, tallies = read_baselines()
    folder = tmp_path_factory.mktemp("run")
    for record in records:
        who = record.identity
        if who.task == "objects/deep/v1" and who.modality in ("force", "image", "fused-equal"):
            write_tally(write_record(folder, record), tallies[record.key])
    return folder


def test_every_line_is_a_claim_of_the_paper_with_its_figures(run, vtbench):
    answer = vtbench("compare", run, "--paper", "--json")
    rows = json.loads(answer.out)["rows"]
    assert {row["split"] for row in rows} == {"random", "held-out-unit"}
    for row in rows:
        assert row["paired"]
        better, worse = row["paper_percent"]
        assert better > worse
        assert row["difference"] == pytest.approx(row["values"][0] - row["values"][1])
        assert row["low"] <= row["difference"] <= row["high"]
        if row["word"] in ("holds", "reversed"):
            assert row["p_holm"] <= 0.05
            assert (row["difference"] > 0) is (row["word"] == "holds")
    claims = {(row["better_in_paper"], row["than"]) for row in rows}
    assert ("jksc@fused-equal", "knn@fused-equal") in claims
    assert ("svm@force", "ksc@force") in claims  # 90.00 above 88.39 in table II


def test_a_wider_margin_calls_more_of_them_equal(run, vtbench):
    words = [
        [row["word"] for row in json.loads(vtbench("compare", run, "--paper", "--json", "--margin", m).out)["rows"]]
        for m in ("1", "20")
    ]
    assert words[1].count("equal here") > words[0].count("equal here")


def test_the_table_names_what_holds(run, vtbench):
    text = vtbench("compare", run, "--paper", "--split", "random").out
    assert "frames, equal weights: the paper's own" in text
    assert "98.9 : 91.3" in text
    assert "Holm-adjusted" in text
    assert "held-out-unit" not in text


def test_another_backbone_keeps_its_orderings_and_stands_in_the_heading(run, vtbench, tmp_path):
    """The records of the usual backbone say the same under another one's name."""
    records, tallies = read_baselines()
    for record in records:
        who = record.identity
        kept = who.task == "objects/deep/v1" and who.modality in ("force", "image", "fused-equal")
        if kept and who.params.get("backbone", USUAL_BACKBONE) == USUAL_BACKBONE:
            other = {"backbone": "mine"} if "backbone" in who.params else {}
            identity = who.model_copy(update={"params": {**who.params, **other}})
            renamed = record.model_copy(update={"identity": identity, "key": record_key(identity)})
            write_tally(write_record(tmp_path, renamed), tallies[record.key])
    usual, ours = (json.loads(vtbench("compare", at, "--paper", "--json").out)["rows"] for at in (run, tmp_path))
    expected = [(row["values"], row["word"]) for row in usual if row["backbone"] == USUAL_BACKBONE]
    assert expected
    assert [(row["values"], row["word"]) for row in ours] == expected
    assert {row["backbone"] for row in ours} == {"mine"}
    assert "equal weights: the paper's own; mine" in vtbench("compare", tmp_path, "--paper").out


def test_what_cannot_be_ordered_is_refused(run, refused, tmp_path):
    assert "leave the rest out" in refused("compare", run, run, "--paper")
    assert "leave the rest out" in refused("compare", run, "--paper", "--methods", "ksc@force")
    records, _ = read_baselines()
    write_record(tmp_path, next(r for r in records if r.identity.modality == "force" and r.status.state == "ok"))
    assert "no pair of them" in refused("compare", tmp_path, "--paper")
