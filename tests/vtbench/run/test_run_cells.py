"""The grid, and what a cell's key depends on: all that decides its result, and nothing else."""

from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest

from tests.vtbench.run import small
from vtbench.run.cells import Source, own_methods, plan
from vtbench.run.choose import WEIGHT_CHOICES
from vtbench.run.methods import METHODS
from vtbench.run.suite import Suite
from vtbench.tasks import TASKS
from vtbench.tasks.base import TaskData
from vtbench.tasks.presses import backbone_identity

BACKBONE = backbone_identity("efficientnet-lite0")
BASE = {
    "id": "grid",
    "title": "a grid",
    "datasets": [{"id": "own", "path": "somewhere"}, {"id": "no-variation", "path": "elsewhere"}],
    "methods": {"mine": {**small.own("Nearest", power=1), "choose": {"delay_s": [0, 1]}}},
    "entries": [
        {
            "task": "objects/deep/v1",
            "variants": ["own"],
            "splits": ["random"],
            "modalities": ["force", "image", "fused"],
            "methods": ["knn", "mine"],
            "probes": False,
        }
    ],
}


class Everywhere(dict):
    """The same source for every task and variant."""

    def __init__(self, **changes):
        super().__init__()
        self.source = Source(**{"dataset": "own", "hash": "abc", "kind": "simulated", **changes})

    def __missing__(self, name):
        return self.source


def cells(changes=None, *, entry=None, source=None, backbone=BACKBONE):
    suite = Suite.model_validate(
        {**BASE, "entries": [{**BASE["entries"][0], **(entry or {})}, *(changes or {}).pop("more", [])]}
        | (changes or {})
    )
    return plan(suite, Everywhere(**(source or {})), backbone, own_methods(suite))


def keys(*given, **named):
    """(feed, method) -> key."""
    return {(c.identity.modality, c.identity.method): c.key for c in cells(*given, **named)}


def changed(other):
    """Which (feed, method) have another key than those of `BASE`."""
    base = keys()
    assert other.keys() == base.keys()
    return {name for name in base if other[name] != base[name]}


ALL = {(feed, method) for feed in ("force", "image", "fused") for method in ("knn", "mine")}
MINE = {name for name in ALL if name[1] == "mine"}


def mine(**spec):
    return keys({"methods": {"mine": {**BASE["methods"]["mine"], **spec}}})


def test_the_grid_is_every_feed_with_every_method_each_once():
    assert set(keys()) == ALL
    assert len(cells()) == len(ALL)
    assert len(cells({"more": [BASE["entries"][0]]})) == len(ALL)
    assert len({c.key for c in cells(entry={"splits": None})}) == 3 * len(ALL)


def test_what_decides_a_result_decides_its_key():
    assert changed(keys({"seed": 1})) == ALL
    assert changed(keys(source={"hash": "abd"})) == ALL
    assert changed(keys(source={"dataset": "other"})) == ALL
    assert changed(keys(source={"kind": "real"})) == ALL
    assert changed(mine(params={"power": 2})) == MINE
    assert changed(mine(choose={"delay_s": [0, 2]})) == MINE
    assert changed(mine(choose={"delay_s": [1, 0]})) == MINE  # ties go to the earlier
    assert changed(mine(estimator=f"{small.OWN}:WholeFloats")) == MINE


def test_a_protocol_version_is_in_every_key(monkeypatch):
    before = keys()
    monkeypatch.setattr("vtbench.run.cells.PROTOCOL_VERSION", 2)
    assert all(key != before[name] for name, key in keys().items())


def test_a_backbone_is_in_the_keys_of_cells_that_are_fed_frames():
    for part in BACKBONE:
        assert changed(keys(backbone={**BACKBONE, part: "f01"})) == {name for name in ALL if name[0] != "force"}


def test_what_decides_no_result_decides_no_key():
    assert not changed(keys({"title": "another", "id": "renamed"}))
    assert not changed(keys({"timeout_s": 1.0}))
    assert not changed(keys({"datasets": [*BASE["datasets"], {"id": "more", "path": "x"}]}))
    assert not changed(keys(source={"missing": "not here"}))
    assert not changed(keys(entry={"methods": ["mine", "knn"], "modalities": ["fused", "image", "force"]}))
    reordered = {"power": 1}
    assert not changed(mine(params=dict(reversed(reordered.items()))))
    other = {"other": small.own("Halves"), **BASE["methods"]}
    assert not changed(keys({"methods": other}))


def test_the_code_of_a_builtin_choice_is_in_its_key():
    suite = Suite.model_validate(BASE)
    methods = own_methods(suite)
    fewer = {**methods, "knn": replace(METHODS.get("knn"), choices={"n_neighbors": (1, 3)})}
    got = {(c.identity.modality, c.identity.method): c.key for c in plan(suite, Everywhere(), BACKBONE, fewer)}
    assert changed(got) == ALL - MINE


def test_chosen_and_equal_weights_are_different_cells():
    got = {c.identity.modality: c for c in cells(entry={"modalities": ["fused", "fused-equal"], "methods": ["knn"]})}
    assert got["fused"].identity.params["weights"] == [list(pair) for pair in WEIGHT_CHOICES]
    assert got["fused-equal"].identity.params["weights"] == "equal"
    assert got["fused"].identity.params["sizes"] == {"image": [16, 32, 64]}


def test_a_joint_method_is_fed_two_modalities_or_none():
    got = {c.identity.modality for c in cells(entry={"methods": ["jksc"]})}
    assert got == {"fused"}


def test_an_entry_that_says_nothing_of_probes_has_them_all():
    task = TASKS.get("objects/deep/v1")
    said = {name: value for name, value in BASE["entries"][0].items() if name != "probes"}
    suite = Suite.model_validate({**BASE, "entries": [said]})
    got = [c.identity for c in plan(suite, Everywhere(), BACKBONE, own_methods(suite)) if c.identity.role == "probe"]
    assert {(who.modality, who.method) for who in got} == {(p, m) for p in task.probes for m in ("knn", "mine")}


def test_probes_and_upper_lines_stand_beside_with_their_roles():
    task = TASKS.get("objects/deep/v1")
    got = cells(entry={"probes": ["knn"], "upper_lines": True})
    roles = {role: {c.identity.modality for c in got if c.identity.role == role} for role in ("probe", "upper-line")}
    assert roles == {"probe": set(task.probes), "upper-line": set(task.upper_lines)}
    assert {c.identity.method for c in got if c.identity.role == "probe"} == {"knn"}
    assert {c.identity.method for c in got if c.identity.role == "upper-line"} == {"knn", "mine"}


def test_laws_replace_the_grid_of_a_variant_that_has_them():
    got = cells(entry={"variants": ["no-variation"], "methods": ["knn"], "modalities": None})
    laws = TASKS.get("objects/deep/v1").variants["no-variation"].laws
    assert {c.identity.modality: c.identity.params["law"] for c in got} == laws
    assert {c.identity.role for c in got} == {"law"}


def test_cells_on_the_same_samples_stand_together():
    got = [c.group for c in cells(entry={"variants": ["own", "no-variation"], "splits": None})]
    assert len(list(groupby(got))) == len(set(got)) == 2


@pytest.mark.parametrize("field", ["variants", "splits", "modalities", "methods"])
def test_a_name_that_is_not_there_is_refused_with_the_close_match(field):
    close = {"variants": "own", "splits": "random", "modalities": "force", "methods": "knn"}[field]
    with pytest.raises(ValueError, match=close):
        cells(entry={field: [f"{close}x"]})


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"datasets": [{"id": "own", "path": "a"}, {"id": "own", "path": "b"}]}, "given twice"),
        ({"datasets": [{"id": "other", "path": "a"}]}, "own"),
        ({"datasets": [{"id": "own", "path": "a", "scene": "b"}]}, "one of the two"),
        ({"datasets": [{"id": "own", "path": "a", "samples": 3}]}, "belong to a scene"),
        ({"methods": {**BASE["methods"], "knn": small.own("Nearest")}}, "built-in"),
        ({"methods": {"mine": {**small.own("Nearest"), "choose": {"power": []}}}}, "at least one value"),
    ],
)
def test_a_suite_that_contradicts_itself_is_refused(changes, what):
    with pytest.raises(ValueError, match=what):
        Suite.model_validate({**BASE, **changes})


def test_two_backbones_on_the_same_presses_share_no_reductions():
    """A process that runs both, one after the other, must not take the first one's components for the second's."""
    from vtbench.run.work import works_of

    data = TaskData(
        ids=np.array([f"{i}" for i in range(40)]),
        labels=np.arange(40) % 4,
        classes=tuple("abcd"),
        factors={},
        rows=np.arange(40),
        sources={"image": lambda: np.zeros((40, 3), np.float32)},
    )
    names = set()
    for backbone in ("efficientnet-lite0", "vgg16"):
        given = {"backbone": backbone, "backbone_sha256": backbone}
        (cell,) = cells({"backbone": backbone}, entry={"modalities": ["image"], "methods": ["knn"]}, backbone=given)
        (work,), _ = works_of([cell], data)
        names.add(work.samples)
    assert len(names) == 2


def test_an_entry_may_bring_its_own_backbone():
    entry = BASE["entries"][0]
    both = cells({"more": [{**entry, "backbone": "pixels"}]})
    by_modality = {m: {c.backbone for c in both if c.identity.modality == m} for m in ("force", "image", "fused")}
    assert by_modality["image"] == by_modality["fused"] == {"efficientnet-lite0", "pixels"}
    assert by_modality["force"] == {"efficientnet-lite0"}
    own = {c.key for c in cells(entry={"backbone": "pixels"}) if c.identity.modality != "force"}
    whole = {c.key for c in cells({"backbone": "pixels"}, backbone=backbone_identity("pixels"))}
    assert own <= whole
    assert own <= {c.key for c in both if c.backbone == "pixels"}
    assert len([key for key, _ in groupby(both, key=lambda c: c.group)]) == 2


def test_an_entry_with_an_unknown_backbone_is_refused():
    with pytest.raises(ValueError, match="unknown backbone 'pixel'; did you mean 'pixels'"):
        cells(entry={"backbone": "pixel"})
