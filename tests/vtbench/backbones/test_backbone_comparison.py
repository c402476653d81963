"""Backbones side by side: costs, scores of a run, differences on the same samples."""

import numpy as np
import pytest

from leaderboard.record import Identity, Metric, Provenance, Record, Status, Timing, record_key
from leaderboard.statistics import paired_group_difference
from leaderboard.tally import tally
from vtbench.backbones.cost import frame_costs
from vtbench.backbones.plot import _MS, _around, draw_error_against_speed
from vtbench.backbones.scores import differences, scores
from vtbench.cli import main

UNITS = np.repeat(np.arange(6), 20)
IDS = np.arange(120)


def record(backbone, value=0.9, **changes):
    who = Identity(
        task="objects/deep/v1",
        variant="paper",
        split="held-out-unit",
        kind="simulated",
        seed=0,
        dataset="paper",
        dataset_hash="d",
        protocol_version=1,
        params={"backbone": backbone, **changes.pop("params", {})},
        **{"method": "knn", "modality": "image", **changes},
    )
    return Record(
        key=record_key(who),
        identity=who,
        status=Status(state="ok"),
        metrics=(Metric(name="accuracy", value=value, n=120, groups=6, low=value - 0.05, high=min(1, value + 0.05)),),
        timing=Timing(threads=1, predict_us_per_sample=20.0, feature_us_per_sample=900.0),
        provenance=Provenance(
            version="1", python="3", fingerprint="f", started="2026-01-01T00:00Z", finished="2026-01-01T00:00Z"
        ),
    )


def right(share, seed):
    return np.random.default_rng(seed).random(120) < share


def test_a_difference_is_the_paired_one_over_groups():
    records = [record("vt-vgg", 0.9), record("pixels", 0.7)]
    ours, theirs = right(0.9, 0), right(0.7, 1)
    tallies = {
        r.key: tally(correct, UNITS.astype(str), IDS, 0 * IDS)
        for r, correct in zip(records, (ours, theirs), strict=True)
    }
    (gap,) = differences(scores(records), tallies, "vt-vgg", "pixels")
    expected = paired_group_difference(ours, theirs, UNITS)
    assert (gap.value, gap.low, gap.high) == pytest.approx((expected.value, expected.low, expected.high))
    assert gap.groups == 6
    (turned,) = differences(scores(records), tallies, "pixels", "vt-vgg")
    assert turned.value == pytest.approx(-gap.value)


def test_other_samples_other_methods_and_missing_tallies_are_not_compared():
    records = [record("vt-vgg"), record("pixels")]
    kept = {r.key: tally(right(0.9, 0), UNITS.astype(str), IDS + i, 0 * IDS) for i, r in enumerate(records)}
    assert differences(scores(records), kept, "vt-vgg", "pixels") == []
    assert differences(scores(records), {}, "vt-vgg", "pixels") == []
    assert differences(scores([record("vt-vgg"), record("pixels", method="svm")]), kept, "vt-vgg", "pixels") == []


def test_scores_are_of_frames_alone():
    kept = scores([record("pixels"), record("pixels", modality="fused", params={"weights": "equal"})])
    assert [(s.backbone, s.modality, s.predict_us) for s in kept] == [("pixels", "image", 20.0)]


@pytest.mark.slow
def test_costs_are_of_all_backbones_and_ratios_are_to_vgg16():
    rows = {row.backbone: row for row in frame_costs(["pixels"], frames=1, warm_up=1)}
    assert set(rows) == {"pixels", "vgg16"}
    assert rows["vgg16"].weights == "random"
    assert rows["vgg16"].times_faster_than_vgg16 == 1
    assert rows["pixels"].times_faster_than_vgg16 == pytest.approx(rows["vgg16"].ms_p50 / rows["pixels"].ms_p50)
    assert rows["vgg16"].model_mb > 50 > 1 > rows["pixels"].model_mb


def test_the_picture_holds_every_protocol(tmp_path):
    kept = scores(
        [record("pixels"), record("vt-vgg", 1.0, method="svm"), record("pixels", 0.2, modality="image-change")]
    )
    path = draw_error_against_speed(tmp_path / "plot.png", kept, {"pixels": 1.0, "vt-vgg": 3.0})
    assert path.read_bytes().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="found none"):
        draw_error_against_speed(path, [], {})


@pytest.mark.parametrize("ms", [[3.0, 3.2], [1.5, 2.8, 7.6], [2.0], [0.05, 4000.0]])
def test_the_axis_of_time_holds_every_mark_between_labelled_values(ms):
    low, high = _around(ms)
    assert low < min(ms) <= max(ms) < high
    labelled = [tick for tick in _MS if low <= tick <= high]
    assert labelled
    assert len(labelled) <= 3 or max(ms) / min(ms) > 2.5  # not the whole axis for a few marks


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["nowhere"], "found no suite.yaml"),
        (["--plot", "x.png"], "expected the folder of a run too"),
        (["--frames", "0"], "whole number of at least 1"),
    ],
)
def test_bad_input_is_one_line(words, says, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["backbones", *words]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1
