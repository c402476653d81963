"""Scores against references computed another way."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.metrics import accuracy_score, balanced_accuracy_score

from leaderboard.record import Metric
from leaderboard.statistics import group_interval
from vtbench.run.scoring import score, true_labels, verdict


def predictions(seed, n=120, folds=4, classes=5, groups=20):
    rng = np.random.default_rng(seed)
    truth = rng.integers(0, classes, n)
    truth[:classes] = np.arange(classes)
    label = np.where(rng.random(n) < 0.6, truth, rng.integers(0, classes, n)).astype(np.int32)
    group = np.array([f"g{i}" for i in rng.integers(0, groups, n)])
    return {"label": label, "group": group, "fold": rng.permutation(np.arange(n) % folds)}, truth


def by_name(metrics):
    return {metric.name: metric for metric in metrics}


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), folds=st.integers(2, 6), groups=st.integers(3, 40))
def test_scores_are_what_scikit_learn_gives(seed, folds, groups):
    given_, truth = predictions(seed, folds=folds, groups=groups)
    got = by_name(score(given_, truth))
    by_fold = [accuracy_score(truth[given_["fold"] == f], given_["label"][given_["fold"] == f]) for f in range(folds)]
    expected = {
        "accuracy": accuracy_score(truth, given_["label"]),
        "balanced_accuracy": balanced_accuracy_score(truth, given_["label"]),
        "worst_fold_accuracy": min(by_fold),
        "best_fold_accuracy": max(by_fold),
        "fold_sd": np.std(by_fold, ddof=1),
    }
    assert {name: metric.value for name, metric in got.items()} == pytest.approx(expected)
    assert next(iter(got)) == "accuracy"
    assert got["fold_sd"].direction == "lower"
    accuracy = got["accuracy"]
    assert accuracy.low <= accuracy.value <= accuracy.high


def test_the_interval_counts_groups_and_not_predictions():
    given_, truth = predictions(0)
    correct = given_["label"] == truth
    accuracy = score(given_, truth)[0]
    expected = group_interval(correct, given_["group"])
    assert (accuracy.n, accuracy.groups) == (120, len(np.unique(given_["group"])))
    assert (accuracy.low, accuracy.high, accuracy.interval) == (expected.low, expected.high, expected.method)

    many_times = {name: np.tile(values, 9) for name, values in given_.items()}
    again = score(many_times, np.tile(truth, 9))[0]
    assert (again.n, again.groups) == (9 * 120, accuracy.groups)
    assert (again.low, again.high) == pytest.approx((accuracy.low, accuracy.high))


def test_one_fold_has_no_spread():
    given_, truth = predictions(0, folds=1)
    assert "fold_sd" not in by_name(score(given_, truth))


def test_balanced_accuracy_weighs_classes_alike():
    truth = np.repeat([0, 1], [90, 10])
    lazy = {"label": np.zeros(100, int), "group": np.arange(100).astype(str), "fold": np.arange(100) % 2}
    got = by_name(score(lazy, truth))
    assert (got["accuracy"].value, got["balanced_accuracy"].value) == (0.9, 0.5)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000))
def test_truth_is_joined_by_sample_id_whatever_the_order(seed):
    rng = np.random.default_rng(seed)
    ids = rng.permutation([f"s{i}" for i in range(50)])
    labels = rng.integers(0, 5, 50)
    asked = rng.choice(ids, 80)
    truth = dict(zip(ids.tolist(), labels.tolist(), strict=True))
    assert true_labels({"sample_id": asked}, ids, labels).tolist() == [truth[i] for i in asked.tolist()]


@pytest.mark.parametrize("stranger", ["s1x", "a", "zzz"])
def test_a_prediction_for_no_sample_is_refused(stranger):
    ids = np.array(["s2", "s1", "s3"])
    with pytest.raises(ValueError, match=f"'{stranger}', which the data do not hold"):
        true_labels({"sample_id": np.array(["s1", stranger])}, ids, np.arange(3))


@pytest.mark.parametrize(
    ("law", "value", "passed"),
    [("perfect", 1.0, True), ("perfect", 0.999, False), ("chance", 0.25, True), ("chance", 0.9, False)],
)
def test_a_law_holds_or_is_broken(law, value, passed):
    accuracy = Metric(name="accuracy", value=value, n=1000, groups=100)
    got = verdict(law, accuracy, 4)
    assert got.passed is passed
    assert got.observed == f"{100 * value:.1f} %"
    assert got.expected == ("100.0 %" if law == "perfect" else "25.0 %")


def test_chance_is_judged_by_groups_not_by_repeats_of_them():
    """40 % against 25 % is luck in 20 trials, not in 2000."""
    few, many = (Metric(name="accuracy", value=0.4, n=2000, groups=groups) for groups in (20, 2000))
    assert verdict("chance", few, 4).passed
    assert not verdict("chance", many, 4).passed
