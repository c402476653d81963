"""Variants that test on other features than they train on: choices stay, what is missing is not looked at."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.vtbench.run import small
from vtbench.run.choose import within
from vtbench.run.evaluate import evaluate
from vtbench.run.work import read_block
from vtbench.tasks.base import StandIn, TaskData, Variant

N = small.N
RNG = np.random.default_rng(0)
FORCE, OTHER = RNG.normal(size=(2, N, 3))
DATA = TaskData(
    np.array([str(i) for i in range(N)]),
    np.arange(N) % 4,
    tuple("abcd"),
    {},
    np.arange(N),
    {"force": lambda: FORCE, "other": lambda: OTHER},
)


def variant(**stand_ins):
    return Variant("", {}, stand_ins=stand_ins)


def test_blocks_are_as_trained_then_as_tested():
    force, other = DATA.block("force"), DATA.block("other")
    np.testing.assert_array_equal(read_block(DATA, "force", variant()), force)
    for way, expected in (
        (StandIn(test="other"), [force, other]),
        (StandIn(train="other"), [other, force]),
        (StandIn("other", "other"), [other, other]),
        (StandIn(test="missing"), [force, force]),
    ):
        np.testing.assert_array_equal(read_block(DATA, "force", variant(force=way)), np.concatenate(expected))
    np.testing.assert_array_equal(  # beside one that is read otherwise
        read_block(DATA, "force", variant(other=StandIn(test="force"))), np.concatenate([force, force])
    )


def doubled(work, **tested):
    """The work with a second copy of each block to test on."""
    blocks = {name: np.concatenate([block, tested.get(name, block)]) for name, block in work.blocks.items()}
    return replace(work, blocks=blocks, tested_from=len(work.labels), samples=f"{work.samples} {sorted(tested)}")


@pytest.mark.parametrize("method", ["jksc", "jksc-independent", "knn", "svm"])
def test_testing_on_the_same_features_is_the_plain_run(method):
    work = small.work(small.method(method))
    plain, twice = evaluate(work).predictions, evaluate(doubled(work)).predictions
    for name in ("label", "choices", "sample_id"):
        np.testing.assert_array_equal(plain[name], twice[name])


@pytest.mark.parametrize("method", ["jksc", "svm"])
def test_test_features_move_predictions_and_no_choice(method):
    work = small.work(small.method(method))
    noise = {name: RNG.normal(size=block.shape).astype(np.float32) for name, block in work.blocks.items()}
    plain, other = evaluate(work).predictions, evaluate(doubled(work, **noise)).predictions
    np.testing.assert_array_equal(plain["choices"], other["choices"])
    assert (plain["label"] != other["label"]).any()


@pytest.mark.parametrize("method", ["jksc", "jksc-independent", "knn", "svm"])
@pytest.mark.parametrize("gone", ["force", "image"])
def test_what_is_missing_is_not_looked_at(method, gone):
    work = small.work(small.method(method))
    results = []
    for number in range(2):
        garbage = {gone: RNG.normal(size=work.blocks[gone].shape).astype(np.float32) * 9}
        lacking = replace(doubled(work, **garbage), missing=(gone,), samples=f"{gone} {number}")
        results.append(evaluate(lacking).predictions)
    np.testing.assert_array_equal(results[0]["label"], results[1]["label"])
    np.testing.assert_array_equal(results[0]["scores"], results[1]["scores"])


def test_equal_training_parts_are_chosen_on_once():
    work = replace(small.work(small.method("svm")), trained="the same presses")
    first = evaluate(work).predictions
    flipped = {name: -block for name, block in work.blocks.items()}
    again = evaluate(doubled(work, **flipped)).predictions
    assert first["choices"].tolist() == again["choices"].tolist()
    assert all(set(json.loads(each)) == {"sizes", "weights", "params"} for each in first["choices"])


def test_no_more_neighbours_than_samples():
    assert within({"n_neighbors": 5, "p": 2}, 3) == {"n_neighbors": 3, "p": 2}
    assert within({"n_neighbors": 5}, 9) == {"n_neighbors": 5}
    assert within({"C": 1.0}, 1) == {"C": 1.0}
    work = small.work(small.method("knn"), small.FORCE)
    few = replace(
        work,
        split=replace(
            work.split,
            folds=tuple(
                replace(fold, train=np.array([int(np.flatnonzero(work.labels == c)[0]) for c in range(3)]))
                for fold in work.split.folds
            ),
        ),
    )
    assert len(evaluate(few).predictions["label"])
