import copy

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from vtbench import config
from vtbench.paths import configs_dir

keys = st.sampled_from(["a", "b", "c"])
trees = st.recursive(st.integers(), lambda inner: st.dictionaries(keys, inner, max_size=3), max_leaves=8)
mappings = st.dictionaries(keys, trees, max_size=3)

SCENE = {
    "id": "mine",
    "title": "my presses",
    "objects": ["coin-1-euro", "coin-2-euro"],
    "pose": {"reseat_mm": 0.25},
    "variations": {"same": {}, "loose": {"title": "loose", "pose": {"jitter_mm": 2.0}}},
}


@pytest.fixture
def own_scene(tmp_path):
    def write(**changes):
        path = tmp_path / "my-scene.yaml"
        path.write_text(yaml.safe_dump({**SCENE, **changes}, sort_keys=False))
        return path

    return write


@given(mappings)
def test_merging_nothing_changes_nothing(tree):
    assert config.deep_merge(tree, {}) == tree == config.deep_merge({}, tree)
    assert config.deep_merge(tree, tree) == tree


@given(mappings, mappings)
def test_what_is_laid_over_wins_and_the_rest_stays(base, over):
    before = copy.deepcopy((base, over))
    merged = config.deep_merge(base, over)
    assert (base, over) == before
    assert set(merged) == set(base) | set(over)
    for key in merged:
        if key not in over:
            assert merged[key] == base[key]
        elif key in base and isinstance(base[key], dict) and isinstance(over[key], dict):
            assert merged[key] == config.deep_merge(base[key], over[key])
        else:
            assert merged[key] == over[key]


def test_the_merged_mapping_shares_nothing_with_its_parts():
    base, over = {"a": {"x": [1]}}, {"b": {"y": [2]}}
    merged = config.deep_merge(base, over)
    merged["a"]["x"].append(3)
    merged["b"]["y"].append(3)
    assert (base, over) == ({"a": {"x": [1]}}, {"b": {"y": [2]}})


def test_dotted_keys_become_nested_mappings():
    assert config.from_dotted({"a.b": 1, "a.c": 2, "d": {"e": 3}}) == {"a": {"b": 1, "c": 2}, "d": {"e": 3}}


@pytest.mark.parametrize("settings", [{"a": 1, "a.b": 2}, {"a.b": 2, "a": 1}, {"a..b": 1}, {"": 1}])
def test_dotted_keys_that_contradict_are_refused(settings):
    with pytest.raises(ValueError, match=r"set twice|key above|expected a key"):
        config.from_dotted(settings)


def test_every_scene_loads_under_its_own_name():
    names = config.scene_names()
    assert {"fvsight-press", "fvsight-press/default", "fvsight-press/hard"} <= set(names)
    assert [config.load_scene(name).id for name in names] == names


def test_every_suite_loads_under_its_own_name():
    names = config.suite_names()
    assert {"quick", "fvsight", "texture-real"} <= set(names)
    assert [config.load_suite(name).id for name in names] == names


def test_a_variation_changes_what_it_names_and_nothing_else():
    base, loose = config.load_scene("fvsight-press"), config.load_scene("fvsight-press/hard")
    assert loose.pose != base.pose
    assert loose.pose.reseat_mm == base.pose.reseat_mm
    assert (loose.sensor, loose.protocol, loose.load) == (base.sensor, base.protocol, base.load)


def test_an_empty_variation_is_the_scene_itself():
    assert config.load_scene("fvsight-press/paper") == config.load_scene("fvsight-press")


def test_ones_own_file_loads_like_a_scene_of_vtbench(own_scene):
    path = own_scene()
    assert config.load_scene(path).id == config.load_scene(f"{path}/same").id == "mine"
    loose = config.load_scene(f"{path}/loose")
    assert (loose.id, loose.pose.jitter_mm, loose.pose.reseat_mm) == ("mine/loose", 2.0, 0.25)
    assert config.variation_names(path) == ["same", "loose"]
    assert config.variation_names(f"{path}/loose") == []


def test_overrides_are_laid_on_last(own_scene):
    scene = config.load_scene(f"{own_scene()}/loose", {"pose.jitter_mm": 3.0, "protocol": {"units": 1}})
    assert (scene.pose.jitter_mm, scene.pose.reseat_mm, scene.protocol.units) == (3.0, 0.25, 1)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("fvsight-pres", r"unknown scene 'fvsight-pres'; did you mean 'fvsight-press' .*`vtbench list scenes`"),
        ("fvsight-press/hrd", r"unknown variation of fvsight-press 'hrd'; did you mean 'hard'\?"),
        ("", "unknown scene ''"),
        ("nowhere.yaml", "nowhere.yaml: no such file"),
        ("../configs/scenes/fvsight-press", "unknown scene"),
    ],
)
def test_an_unknown_scene_is_refused(name, message):
    with pytest.raises(ValueError, match=message):
        config.load_scene(name)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"psoe": {}}, r"my-scene.yaml:\d+: psoe: unknown key; did you mean 'pose'\?"),
        ({"pose": {"reseat_m": 1}}, r"my-scene.yaml:\d+: pose.reseat_m: unknown key; did you mean 'reseat_mm'"),
        ({"pose": {"reseat_mm": -1}}, r"pose.reseat_mm: expected a value greater than or equal to 0, got -1"),
        ({"objects": ["coin-1-eur"]}, "no household object is called 'coin-1-eur'; did you mean 'coin-1-euro'"),
        ({"variations": [1]}, "variations: expected a mapping of names to changed keys"),
        ({"variations": {"a": 3}}, "variations.a: expected a mapping of changed keys, got 3"),
        ({"variations": {"a/b": {}}}, "variations: expected a name without '/', .* got 'a/b'"),
        ({"variations": {"a b": {}}}, r"yaml:\d+: variations: expected a name without .* or blanks, got 'a b'"),
        (
            {"kind": "push"},
            r"yaml:\d+: kind: expected 'press' \(.+\) or 'slide' \(.+\), got 'push'; .* 'press'\?",
        ),
        ({"kind": "slip"}, r"kind: expected 'press' .* or 'slide' .*, got 'slip'; did you mean 'slide'\?"),
        ({"kind": 3}, r"kind: expected 'press' .* or 'slide' \([^)]+\), got 3$"),
        ({"kind": ["slide"]}, r"kind: expected 'press' .*, got \['slide'\]"),
        (
            {"sensor": "digit"},
            r"sensor: got 'digit', .*FVSight.* hollow skin .* plate.*; expected a mapping of .*grid",
        ),
        *(
            ({"id": wrong}, "id: expected words joined by '/'")
            for wrong in ("a b", "/a", "a/", "a//b", "../a", "a|b", "")
        ),
    ],
)
def test_a_bad_scene_names_file_key_expected_and_got(own_scene, changes, message):
    path = own_scene(**changes)
    with pytest.raises(ValueError, match=message) as failure:
        config.load_scene(f"{path}/loose" if "variations" in changes else path)
    assert str(path) in str(failure.value)
    assert "\n" not in str(failure.value)


def test_a_problem_inside_a_variation_has_the_line_it_stands_on(own_scene):
    path = own_scene(variations={"tight": {"pose": {"jitter_m": 1}}})
    line = 1 + next(i for i, text in enumerate(path.read_text().splitlines()) if "jitter_m:" in text)
    assert config.load_scene(path).id == "mine"
    with pytest.raises(ValueError, match=rf"my-scene\.yaml:{line}: pose\.jitter_m: unknown key"):
        config.load_scene(f"{path}/tight")


def test_an_override_is_not_blamed_on_a_line_of_the_file(own_scene):
    with pytest.raises(ValueError, match=r"my-scene\.yaml: pose\.reseat_mm: expected"):
        config.load_scene(own_scene(), {"pose.reseat_mm": -1})


def test_a_suite_from_a_file_names_the_key_of_its_problem(tmp_path):
    path = tmp_path / "suite.yaml"
    path.write_text((configs_dir() / "suites" / "quick.yaml").read_text().replace("methods:", "methds:", 1))
    with pytest.raises(ValueError, match=r"suite\.yaml:\d+: entries\[0\]\.methds: unknown key; did you mean 'methods'"):
        config.load_suite(path)


@pytest.mark.parametrize(
    ("key", "wrong", "message"),
    [
        (
            "backbone",
            "vgg61",
            r"backbone: unknown backbone 'vgg61'; did you mean 'vgg16'\? \(`vtbench list backbones`\)",
        ),
        ("truth", ["pressur"], r"datasets\[0\]\.truth: unknown field 'pressur'; did you mean 'pressure'"),
        ("splits", [], r"entries\[0\]\.splits: .* at least 1 item"),
        ("modalities", [], r"entries\[0\]\.modalities: .* at least 1 item"),
    ],
)
def test_what_a_suite_names_is_there_before_any_work(tmp_path, key, wrong, message):
    suite = yaml.safe_load((configs_dir() / "suites" / "quick.yaml").read_text())
    place = {"backbone": suite, "truth": suite["datasets"][0]}.get(key, suite["entries"][0])
    place[key] = wrong
    path = tmp_path / "suite.yaml"
    path.write_text(yaml.safe_dump(suite))
    with pytest.raises(ValueError, match=message):
        config.load_suite(path)


@pytest.mark.parametrize("good", ["fvsight-press/hard", "Löffel_2+3", "a.b/c(1)"])
def test_an_id_may_have_folders(own_scene, good):
    assert config.load_scene(own_scene(id=good)).id == good


SUITE = """\
id: mine
title: t
datasets:
  - {id: paper, scene: my-scene.yaml/loose}
entries:
  - {task: objects/deep/v1, variants: [paper], methods: [svm]}
"""


def test_a_scene_and_a_suite_are_not_taken_for_one_another(own_scene, tmp_path):
    scene, suite = own_scene(), tmp_path / "suite.yaml"
    suite.write_text(SUITE)
    with pytest.raises(ValueError, match=r"my-scene\.yaml: this is a scene, not a suite: `vtbench generate .*`scene: "):
        config.load_suite(scene)
    with pytest.raises(ValueError, match=r"suite\.yaml: this is a suite, not a scene: `vtbench run "):
        config.load_scene(suite)
    with pytest.raises(ValueError, match=r"'fvsight-press/hard' is a scene, not a suite: `vtbench generate fvsight"):
        config.load_suite("fvsight-press/hard")
    with pytest.raises(ValueError, match=r"'quick' is a suite, not a scene: `vtbench run quick"):
        config.load_scene("quick")


def test_a_suite_finds_a_scene_beside_itself_from_any_folder(own_scene, tmp_path, monkeypatch):
    scene, suite = own_scene(), tmp_path / "suite.yaml"
    suite.write_text(SUITE)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    (found,) = config.load_suite("../suite.yaml").datasets
    assert config.load_scene(found.scene).id == "mine/loose"
    monkeypatch.chdir(tmp_path)
    scene.rename(tmp_path / "elsewhere/my-scene.yaml")
    suite.rename(tmp_path / "elsewhere/suite.yaml")
    assert config.load_suite("elsewhere/suite.yaml").datasets[0].scene == "elsewhere/my-scene.yaml/loose"


@pytest.mark.parametrize("wrong", ["a b", "a/b", "..", "Paper", ""])
def test_an_id_that_names_a_folder_or_a_column_is_one_plain_word(tmp_path, wrong):
    path = tmp_path / "suite.yaml"
    for place in ("id: mine", "id: paper"):
        path.write_text(SUITE.replace(place, f"id: {wrong!r}", 1))
        with pytest.raises(ValueError, match=r"id: expected a word of small letters, digits, '_', '-' and '\.', got "):
            config.load_suite(path)


def test_an_unknown_suite_is_refused():
    with pytest.raises(ValueError, match=r"unknown suite 'quik'; did you mean 'quick'\? \(`vtbench list suites`\)"):
        config.load_suite("quik")
    with pytest.raises(ValueError, match="no variations, got 'x'"):
        config.load_suite("quick/x")
