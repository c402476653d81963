"""A classifier of one's own, by import path: what is wrong with it is said in one line before any cell runs."""

import re

import numpy as np
import pytest

from tests.vtbench.run import small
from vtbench.run import run_suite
from vtbench.run.methods.external import check_external, external_method


def refused(estimator, params=None, choices=None):
    with pytest.raises(ValueError, match=re.escape(estimator)) as error:
        check_external(external_method("mine", estimator, params or {}, choices or {}))
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.fixture
def module(tmp_path, monkeypatch):
    """`module(name, source)` writes a module into the current folder."""
    monkeypatch.chdir(tmp_path)

    def write(name, source):
        (tmp_path / f"{name}.py").write_text(source)
        return name

    return write


@pytest.mark.parametrize(
    ("estimator", "what"),
    [
        ("no_such_package.mod:Mine", "no module 'no_such_package.mod'"),
        ("sklearn.no_such_module:Mine", "no module"),
        (f"{small.OWN}:Neares", "has no class 'Neares'"),
        (f"{small.OWN}:not_a_class", "is a function, expected a class"),
        (f"{small.OWN}:NoPredict", "has no predict()"),
        ("Nearest", "expected 'package.module:Class'"),
        ("a b:Nearest", "expected 'package.module:Class'"),
        (f"{small.OWN}:Nearest.fit", "expected 'package.module:Class'"),
    ],
)
def test_a_path_to_no_classifier_is_refused(estimator, what):
    assert what in refused(estimator)


def test_a_misspelt_class_gets_the_close_match():
    assert "'Nearest'" in refused(f"{small.OWN}:Neares")


def test_arguments_that_the_class_refuses_are_shown():
    message = refused(f"{small.OWN}:Nearest", {"colour": 3})
    assert "{'colour': 3}" in message
    assert "unexpected keyword argument 'colour'" in message
    assert "'colour'" in refused(f"{small.OWN}:Nearest", {}, {"colour": (1, 2)})


def test_a_module_that_fails_to_import_says_how(module):
    name = module("own_broken_at_import", "1 / 0\n")
    assert "ZeroDivisionError" in refused(f"{name}:Mine")
    name = module("own_needs_more", "import no_such_thing_at_all\nclass Mine: pass\n")
    assert "no_such_thing_at_all" in refused(f"{name}:Mine")


def test_the_current_folder_is_searched_and_left_out_of_the_path_again(module):
    import sys

    before = list(sys.path)
    name = module("own_in_this_folder", "class Mine:\n    def fit(self, X, y): ...\n    def predict(self, X): ...\n")
    check_external(external_method("mine", f"{name}:Mine", {}, {}))
    assert sys.path == before


def test_parameters_are_given_and_chosen_ones_win():
    method = external_method("mine", f"{small.OWN}:Nearest", {"power": 3, "log": ""}, {"power": (1, 2)})
    assert method.build({}, {}, {"power": 2}).power == 2
    assert method.build({}, {}, {}).power == 3


def test_the_key_changes_with_the_code(module):
    def identity(source):
        name = module("own_edited", source)
        return external_method("mine", f"{name}:Mine", {}, {}).identity()

    one = identity("class Mine: pass\n")
    assert identity("class Mine: pass\n") == one
    other = identity("class Mine: pass  # better\n")
    assert other != one
    assert {**other, "sha256": one["sha256"]} == one


@pytest.mark.parametrize("name", ["NoPredict", "Neares"])
def test_a_run_with_a_class_that_cannot_be_made_stops_before_any_cell(presses, tmp_path, name):
    suite = small.suite(presses, ["knn", "mine"], {"mine": small.own(name)})
    with pytest.raises(ValueError, match=name):
        run_suite(suite, tmp_path / "run", progress=False)
    assert list(tmp_path.glob("run/runs/*")) == []


def test_scores_are_kept_in_the_order_of_the_tasks_classes():
    """A classifier that never saw a class has minus infinity there, and its own classes in their places."""
    from vtbench.run.evaluate import evaluate

    _, labels, _ = small.samples()
    gap = np.where(labels == 1, 2, labels)
    got = evaluate(small.work(small.method("Nearest"), small.FORCE, labels=gap)).predictions
    assert got["scores"].shape == (20, 3)
    assert np.isneginf(got["scores"][:, 1]).all()
    np.testing.assert_array_equal(np.argmax(got["scores"], 1), got["label"])
