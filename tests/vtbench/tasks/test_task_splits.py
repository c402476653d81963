"""Laws of the splits: no leakage, the paper's ratios, the same draws from the same seed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vtbench.tasks import TASKS
from vtbench.tasks.base import Fold, NotPossibleError, Split, TaskData
from vtbench.tasks.splits import guarded, held_out, random_draws


def presses(objects: int = 5, units: int = 3, rounds: int = 12, shallow: tuple[int, ...] = (5, 11)) -> TaskData:
    rng = np.random.default_rng(0)
    unit, press, label = (
        grid.ravel() for grid in np.meshgrid(np.arange(units), np.arange(rounds), np.arange(objects), indexing="ij")
    )
    n = len(label)
    return TaskData(
        ids=np.array([f"{i:06d}" for i in range(n)]),
        labels=label.astype(np.int64),
        classes=tuple(f"object-{i}" for i in range(objects)),
        factors={
            "unit": unit,
            "session": np.array([f"{u}.{r // 3}" for u, r in zip(unit, press, strict=True)]),
            "press": np.where(np.isin(press, shallow), "shallow", "deep"),
            "label": label,
            **{name: rng.normal(size=n) for name in ("pose_x_mm", "pose_y_mm", "pose_deg")},
        },
        rows=np.arange(n),
        sources={},
    )


def deep(data: TaskData) -> TaskData:
    return data.take(data.factors["press"] == "deep")


@settings(max_examples=30, deadline=None)
@given(
    objects=st.integers(2, 6),
    units=st.integers(1, 4),
    rounds=st.integers(2, 15),
    fraction=st.floats(0.05, 0.6),
    seed=st.integers(0, 99),
)
def test_random_draws_part_every_stratum(objects: int, units: int, rounds: int, fraction: float, seed: int) -> None:
    data = presses(objects, units, rounds, shallow=())
    split = random_draws(test_fraction=fraction, strata=("unit",))(data, seed)
    expected = max(1, round(fraction * rounds))
    assert len(split.folds) == 10
    for fold in split.folds:
        assert not set(fold.train) & set(fold.test)
        assert len(fold.train) + len(fold.test) == len(data)
        stratum = data.labels[fold.test] * 10 + data.factors["unit"][fold.test]
        assert set(np.bincount(stratum)[np.unique(stratum)]) == {expected}


def test_the_papers_ratios() -> None:
    paper = {
        name: TASKS.get(f"objects/{name}/v1").variants["paper"].splits["random"] for name in ("deep", "interference")
    }
    data = presses(objects=27)
    for fold in paper["deep"](deep(data), 0).folds:
        assert (len(fold.train), len(fold.test)) == (9 * 27, 27)
        assert set(deep(data).factors["unit"][np.concatenate([fold.train, fold.test])]) == {0}
    for fold in paper["interference"](data, 0).folds:
        assert (len(fold.train), len(fold.test)) == (11 * 27, 27)


def test_draws_depend_on_the_seed_alone() -> None:
    rule, data = random_draws(test_fraction=0.1), presses()
    again = [fold.test.tolist() for fold in rule(data, 1).folds]
    assert [fold.test.tolist() for fold in rule(presses(), 1).folds] == again
    assert [fold.test.tolist() for fold in rule(data, 2).folds] != again
    assert len({tuple(test) for test in again}) == 10


def test_intervals_of_random_draws_group_by_press() -> None:
    data = presses()
    split = random_draws(test_fraction=0.1)(data, 0)
    assert split.interval_groups.tolist() == data.ids.tolist()


def test_held_out_unit_is_absent_from_training_and_tested_once() -> None:
    data = presses()
    split = held_out("unit")(data, 0)
    unit = data.factors["unit"]
    assert [np.unique(unit[fold.test]).tolist() for fold in split.folds] == [[0], [1], [2]]
    for fold in split.folds:
        assert not set(unit[fold.train]) & set(unit[fold.test])
    assert np.sort(np.concatenate([fold.test for fold in split.folds])).tolist() == list(range(len(data)))
    assert split.interval_groups.tolist() == unit.astype(str).tolist()


def test_hard_refuses_a_pose_seen_in_training() -> None:
    rule = TASKS.get("objects/interference/v1").variants["hard"].splits["held-out-unit"]
    data = presses()
    assert len(rule(data, 0).folds) == 3
    same = dict.fromkeys(("pose_x_mm", "pose_y_mm", "pose_deg"), np.zeros(len(data)))
    data.factors = {**data.factors, **same}
    with pytest.raises(NotPossibleError, match="unseen occurs in training"):
        rule(data, 0)


def test_deep_task_takes_deep_presses_only_and_interference_all() -> None:
    data = presses()
    assert set(deep(data).factors["press"]) == {"deep"}
    assert len(deep(data)) == len(data) * 10 // 12


@pytest.mark.parametrize(
    ("train", "test", "what"),
    [
        ([0, 1, 2], [2, 3], "both the training and the test part"),
        ([], [0], "empty"),
        ([0, 1], [], "empty"),
        ([0, 5], [1], "one class only"),
    ],
)
def test_a_leaking_or_empty_fold_is_refused(train: list[int], test: list[int], what: str) -> None:
    data = presses()
    fold = Fold("bad", np.array(train, np.int64), np.array(test, np.int64))
    with pytest.raises(NotPossibleError, match=what):
        guarded(Split("s", (fold,), data.ids, "press"), data)


def test_one_unit_cannot_be_held_out() -> None:
    with pytest.raises(NotPossibleError, match="one unit only"):
        held_out("unit")(presses(units=1), 0)


def test_every_task_names_a_held_out_condition_and_probes() -> None:
    for _, task in TASKS.items():
        splits = {name for variant in task.variants.values() for name in variant.splits}
        assert any(name.startswith("held-out-") for name in splits)
        assert task.probes
        if task.reads != "slides":  # a detector of slip has no labels to draw evenly or to shuffle
            assert "random" in splits
            assert "shuffled-labels" in task.probes
        for variant in task.variants.values():
            for feed in variant.laws:
                task.feed(feed)
