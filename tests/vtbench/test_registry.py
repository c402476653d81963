import pytest
from hypothesis import given
from hypothesis import strategies as st

from vtbench.registry import Registry, close_matches, hint, unknown

words = st.text(alphabet="abcdefgh/-0123456789", min_size=3, max_size=20)


@pytest.fixture
def tasks():
    registry = Registry("task", see="vtbench list tasks")
    for name in ("objects/deep/v1", "objects/interference/v1", "texture/fabricslide16/v1"):
        registry.register(name)(name.upper())
    return registry


@given(st.lists(words, min_size=1, max_size=8, unique=True), st.data())
def test_a_known_word_is_its_own_closest_match(choices, data):
    word = data.draw(st.sampled_from(choices))
    assert close_matches(word, choices)[0] == word


@given(words, st.lists(words, max_size=8))
def test_matches_are_choices_and_none_comes_twice(word, choices):
    found = close_matches(word, choices)
    assert set(found) <= set(choices)
    assert len(set(found)) == len(found) <= 3


@pytest.mark.parametrize(
    ("word", "best"),
    [
        ("objects/dep/v1", "objects/deep/v1"),
        ("objects/deep", "objects/deep/v1"),
        ("OBJECTS/DEEP/V1", "objects/deep/v1"),
        ("fabricslide16/v1", "texture/fabricslide16/v1"),
    ],
)
def test_a_misspelt_id_is_refused_with_the_closest(tasks, word, best):
    with pytest.raises(ValueError, match=rf"unknown task '{word}'; did you mean '{best}'.*`vtbench list tasks`"):
        tasks.get(word)


def test_a_few_choices_are_listed_where_none_is_close():
    assert hint("zzz", ["paper", "hard"]) == "; known: paper, hard"
    assert hint("zzz", [f"choice-{i}" for i in range(100)]) == ""
    assert hint("zzz", []) == ""


def test_an_error_without_choices_still_names_the_word():
    assert str(unknown("suite", "x", [])) == "unknown suite 'x'"


def test_parts_come_back_in_their_order(tasks):
    assert tasks.ids() == tuple(tasks) == tuple(name for name, _ in tasks.items())
    assert [tasks.get(name) for name in tasks] == [part for _, part in tasks.items()]
    assert len(tasks) == 3
    assert "objects/deep/v1" in tasks
    assert "objects/deep" not in tasks


def test_register_gives_the_part_back():
    registry = Registry("thing")
    part = object()
    assert registry.register("part")(part) is part is registry.get("part")


def test_an_id_is_taken_once(tasks):
    with pytest.raises(ValueError, match="registered twice"):
        tasks.register("objects/deep/v1")


@pytest.mark.parametrize("bad", ["", "Objects", "a//b", "/a", "a/", "a b", "ä"])
def test_a_malformed_id_is_refused(bad):
    with pytest.raises(ValueError, match="expected lower-case words"):
        Registry("task").register(bad)
