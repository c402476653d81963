"""A model that says itself that it was fitted on what it is tested on is scored, and flagged."""

import json

import onnx
import pytest
from onnx import helper

from vtbench.onnx_eval import inspect_graph
from vtbench.onnx_eval.tested import on_datasets

TASK = "objects/interference/v1"


def said(dataset_hash, fold="run-0", **more):
    fit = {"part": "train", "fold": fold, "samples": 3, "seed": 0}
    return {"dataset_hash": dataset_hash, "variant": "own", "split": "random", "fit": fit, **more}


def labelled(path, entry):
    model = onnx.load(path)
    helper.set_model_props(model, {"vtbench": entry})
    path.write_bytes(model.SerializeToString())
    return path


def read(path):
    return inspect_graph.read(path.read_bytes())[0].fitted_on


def test_a_test_that_the_model_has_not_seen_is_not_doubted(presses, tested, honest):
    told = read(labelled(honest, json.dumps(said(tested.dataset_hash))))
    own = on_datasets(TASK, "own", "random", [presses], fold="run-0")
    assert own.seen_in_fitting(told) == []
    assert own.seen_in_fitting({}) == []
    (whole,) = tested.seen_in_fitting(told)
    assert "--variant own --split random --fold run-0 --seed 0" in whole
    (other,) = on_datasets(TASK, "own", "random", [presses], fold="run-1").seen_in_fitting(told)
    assert other == whole
    assert on_datasets(TASK, "own", "random", [presses], fold="run-0", seed=1).seen_in_fitting(told)
    elsewhere = read(labelled(honest, json.dumps(said("0" * 64))))
    assert tested.seen_in_fitting(elsewhere) == []
    everything = read(labelled(honest, json.dumps(said(tested.dataset_hash, fold="all"))))
    assert "on all of these recordings" in own.seen_in_fitting(everything)[0]
    assert read(labelled(honest, json.dumps(said(tested.dataset_hash, learns=False)))) == {}


@pytest.mark.parametrize(
    "entry", ["", "{", "[]", "7", '{"dataset_hash": 3}', "[" * 50_000, json.dumps(said("a", fold="x" * 200_000))]
)
def test_metadata_may_hold_anything(honest, entry):
    assert read(labelled(honest, entry)) == {}


def test_what_is_told_is_short_and_plain(honest):
    told = read(labelled(honest, json.dumps(said("a" * 900, fold="<b>\x00" + "y" * 300))))
    assert all(len(value) <= 64 for value in told.values())
    assert "\x00" not in told["fold"]


@pytest.mark.slow
def test_the_score_stands_and_the_record_is_flagged(judged, honest, tested):
    record = judged(labelled(honest, json.dumps(said(tested.dataset_hash))))
    assert record.status.state == "ok"
    assert record.submission.status == "flagged"
    assert "fitted on some of these recordings" in record.submission.reason
