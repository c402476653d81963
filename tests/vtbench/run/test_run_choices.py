"""Choices are made on the training part; the test part is touched once, by the final model."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.vtbench.run import small
from vtbench.run.choose import WEIGHT_CHOICES, Setting, choose, first_setting, inner_folds, prepare
from vtbench.run.evaluate import evaluate
from vtbench.run.methods import METHODS
from vtbench.run.reduce import Reducer
from vtbench.tasks.base import Block, Feed, Fold

EVERY = METHODS.ids()
TRAIN, TEST = np.arange(40), np.arange(40, 60)


def outcome(method_id, name, **changes):
    """Predictions of one cell; `name` keeps what is remembered of its samples apart."""
    return evaluate(small.work(METHODS.get(method_id), samples_name=name, **changes)).predictions


@pytest.mark.parametrize("method_id", EVERY)
def test_other_test_rows_change_neither_choices_nor_predictions_on_the_rest(method_id):
    clean = outcome(method_id, "clean")
    blocks, _, _ = small.samples()
    poisoned = {name: values.copy() for name, values in blocks.items()}
    for values in poisoned.values():
        values[50:] = 1e4 * np.random.default_rng(1).normal(size=values[50:].shape)
    again = outcome(method_id, "poisoned", blocks=poisoned)
    assert again["choices"].tolist() == clean["choices"].tolist()
    np.testing.assert_array_equal(again["label"][:10], clean["label"][:10])
    if "scores" in clean:
        np.testing.assert_allclose(again["scores"][:10], clean["scores"][:10], rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("method_id", EVERY)
def test_labels_of_the_test_part_change_nothing(method_id):
    clean = outcome(method_id, "labels")
    _, labels, _ = small.samples()
    poisoned = labels.copy()
    poisoned[TEST] = (labels[TEST] + 1) % 3
    again = outcome(method_id, "labels-poisoned", labels=poisoned)
    for name in clean:
        np.testing.assert_array_equal(again[name], clean[name])


@pytest.mark.parametrize("method_id", ["svm", "jksc", "ipca-wknn"])
def test_training_rows_do_matter(method_id):
    """The two laws above would hold for a method that learns nothing."""
    clean = outcome(method_id, "t")
    _, labels, _ = small.samples()
    other = labels.copy()
    other[TRAIN] = (labels[TRAIN] + 1) % 3
    assert np.mean(outcome(method_id, "t-poisoned", labels=other)["label"] == clean["label"]) < 0.5
    assert np.mean(clean["label"] == labels[TEST]) > 0.5


class Watched(Reducer):
    """Keeps the rows that were asked for."""

    def __init__(self, blocks):
        super().__init__(blocks, "scaled")
        self.asked = []

    def at(self, block, size, train, test):
        self.asked.append((train, test))
        return super().at(block, size, train, test)


@pytest.mark.parametrize("groups", [None, np.repeat(np.arange(4), 10)])
def test_choosing_reads_training_rows_only_and_never_validates_on_what_it_fitted(groups):
    blocks, labels, _ = small.samples()
    shuffled = np.random.default_rng(0).permutation(60)[:40]
    for values in blocks.values():
        values[np.setdiff1d(np.arange(60), shuffled)] = np.nan  # a read would be refused
    reducer = Watched(blocks)
    choose(METHODS.get("svm"), small.FUSED, reducer, shuffled, labels[shuffled], groups, 0)
    assert reducer.asked
    for train, held in reducer.asked:
        assert set(train) | set(held) <= set(shuffled)
        assert not set(train) & set(held)


def test_inner_folds_hold_out_whole_groups():
    labels, groups = np.arange(60) % 3, np.array(["a", "b", "c", "d", "e"])[np.arange(60) // 12]
    folds = inner_folds(labels, groups, 0)
    assert len(folds) == 3
    for train, held in folds:
        assert not set(groups[train]) & set(groups[held])
    assert sorted(np.concatenate([held for _, held in folds])) == list(range(60))


def test_inner_folds_without_groups_deal_every_class_evenly():
    labels = np.repeat([0, 1, 2], [7, 9, 20])
    folds = inner_folds(labels, None, 0)
    assert sorted(np.concatenate([held for _, held in folds])) == list(range(36))
    for train, held in folds:
        assert not set(train) & set(held)
        counts = np.bincount(labels[held], minlength=3) * 3 - np.bincount(labels)
        assert np.abs(counts).max() < 3
        assert abs(len(held) - 12) <= 1
    assert [h.tolist() for _, h in inner_folds(labels, None, 1)] != [h.tolist() for _, h in folds]
    one_group = inner_folds(labels, np.zeros(36), 0)
    assert [h.tolist() for _, h in one_group] == [h.tolist() for _, h in folds]


def test_the_best_setting_wins_and_ties_go_to_the_earlier():
    """Two columns tell the classes; the rest is loud noise, so the smallest size must be chosen."""
    rng = np.random.default_rng(0)
    labels = np.arange(90) % 3
    block = Block("cut", leading=(2, 20, 40))
    signal = np.eye(3)[labels][:, :2] * 6 + rng.normal(size=(90, 2))
    features = np.hstack([signal, rng.normal(size=(90, 38))]).astype(np.float32)
    reducer = Reducer({"cut": features}, "scaled")
    rows = np.arange(90)
    chosen = choose(METHODS.get("knn"), Feed((block,)), reducer, rows, labels, None, 0)
    assert chosen.sizes == {"cut": 2}

    alike = Reducer({"cut": np.repeat(np.eye(3, dtype=np.float32)[labels] * 9, 14, 1)[:, ::-1]}, "scaled")
    tied = choose(METHODS.get("knn"), Feed((replace(block, leading=(40, 41, 42)),)), alike, rows, labels, None, 0)
    assert tied == Setting({"cut": 40}, {"cut": 1.0}, {"n_neighbors": 1})


def test_a_block_of_noise_is_weighed_out_and_equal_weights_stay_equal():
    rng = np.random.default_rng(0)
    labels = np.arange(120) % 3
    good = (np.eye(3)[labels] * 2 + rng.normal(size=(120, 3))).astype(np.float32)
    noise = rng.normal(size=(120, 30)).astype(np.float32)
    reducer = Reducer({"good": good, "noise": noise}, "scaled")
    blocks = (Block("noise"), Block("good"))
    for weights in ("chosen", "equal"):
        feed = Feed(blocks, weights=weights)
        chosen = choose(METHODS.get("knn"), feed, reducer, np.arange(120), labels, None, 0)
        if weights == "chosen":
            assert chosen.weights["noise"] < chosen.weights["good"]
            assert (chosen.weights["noise"], chosen.weights["good"]) in WEIGHT_CHOICES
        else:
            assert chosen.weights == {"noise": 1.0, "good": 1.0}


def test_a_weight_scales_its_columns_unless_the_method_weighs_itself():
    blocks, _, _ = small.samples()
    reducer = Reducer(blocks, "scaled")
    setting = replace(first_setting(METHODS.get("knn"), small.FUSED), weights={"image": 1.0, "force": 0.25})
    plain = replace(setting, weights={"image": 1.0, "force": 1.0})
    columns = setting.sizes["image"]

    def made(method_id, at):
        method = METHODS.get(method_id)
        at = replace(at, params=first_setting(method, small.FUSED).params)
        return prepare(method, small.FUSED, reducer, at, TRAIN, TEST)

    for part in ("train", "test"):
        weighed, whole = getattr(made("knn", setting), part), getattr(made("knn", plain), part)
        np.testing.assert_allclose(weighed[:, :columns], whole[:, :columns])
        np.testing.assert_allclose(weighed[:, columns:], 0.25 * whole[:, columns:])
        np.testing.assert_array_equal(getattr(made("jksc", setting), part), whole)
    joint = made("jksc", setting).classifier
    assert joint.weights == {"image": 1.0, "force": 0.25}
    assert joint.modalities == {"image": slice(0, columns), "force": slice(columns, columns + 5)}


def test_what_was_chosen_on_each_fold_is_kept():
    folds = (Fold("a", TRAIN, TEST), Fold("b", np.arange(20, 60), np.arange(20)))
    got = outcome("knn", "kept", folds=folds)
    chosen = [json.loads(text) for text in got["choices"].tolist()]
    assert len(chosen) == 2
    for choice in chosen:
        assert choice["sizes"]["image"] in small.WIDE.components
        assert choice["params"]["n_neighbors"] in METHODS.get("knn").choices["n_neighbors"]
    assert got["sample_id"].tolist() == [f"{i:03d}" for i in [*TEST, *range(20)]]
    assert got["fold"].tolist() == [0] * 20 + [1] * 20
    assert got["group"].tolist() == got["sample_id"].tolist()


def test_shuffled_labels_are_the_training_labels_in_another_order(monkeypatch):
    from tests.vtbench.run.own_classifiers import Nearest

    seen = []
    plain_fit = Nearest.fit

    def fit(self, x, y):
        seen.append(y)
        return plain_fit(self, x, y)

    monkeypatch.setattr(Nearest, "fit", fit)
    _, labels, _ = small.samples()
    evaluate(small.work(small.method("Nearest"), replace(small.FORCE, shuffle_labels=True)))
    assert np.bincount(seen[-1]).tolist() == np.bincount(labels[TRAIN]).tolist()
    assert np.mean(seen[-1] == labels[TRAIN]) < 0.7
    evaluate(small.work(small.method("Nearest"), small.FORCE))
    np.testing.assert_array_equal(seen[-1], labels[TRAIN])
