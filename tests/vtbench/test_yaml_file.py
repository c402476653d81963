from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from vtbench.yaml_file import parse_yaml, read_yaml

PATH = Path("scene.yaml")
keys = st.text(alphabet="abcdefgh_", min_size=1, max_size=6)
values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(alphabet="abc 1-.", max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=3),
    max_leaves=12,
)


@given(st.dictionaries(keys, values, min_size=1))
def test_what_was_dumped_is_read_back(data):
    assert parse_yaml(yaml.safe_dump(data), PATH).data == data


@given(st.dictionaries(keys, values, min_size=1))
def test_every_key_and_item_has_a_line_of_the_text(data):
    text = yaml.safe_dump(data, default_flow_style=False)
    file = parse_yaml(text, PATH)
    count = len(text.splitlines())

    def paths(value, at=()):
        items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        for key, inner in items:
            yield (*at, key)
            yield from paths(inner, (*at, key))

    assert set(paths(data)) == set(file.lines)
    assert all(1 <= line <= count for line in file.lines.values())


def test_numbers_in_scientific_notation_are_numbers():
    assert parse_yaml("a: 1e-3\nb: -2E+4\nc: 1.5e3\nd: e3\ne: '1e3'\nf: 1e3a", PATH).data == {
        "a": 1e-3,
        "b": -2e4,
        "c": 1.5e3,
        "d": "e3",
        "e": "1e3",
        "f": "1e3a",
    }


def test_merged_keys_count_with_the_line_they_stand_on():
    file = parse_yaml("base: &b {x: 1, y: 2}\nuse:\n  <<: *b\n  y: 3", PATH)
    assert file.data["use"] == {"x": 1, "y": 3}
    assert file.lines["use", "x"] == 1
    assert file.lines["use", "y"] == 4


def test_a_mapping_merged_into_a_merged_one_is_no_key_given_twice():
    assert parse_yaml("y: &y {c: 1}\na: {d: &x {<<: *y, c: 3}}\ne: {<<: [*x, *y]}", PATH).data["e"] == {"c": 3}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\nb: 2\na: 3", "scene.yaml:3: key 'a' is given twice, first on line 1"),
        ("a:\n  b: 1\n  b: 2", "scene.yaml:3: key 'b' is given twice, first on line 2"),
        ("a: [1, 2", "scene.yaml:1: not valid YAML"),
        ("a: 1\n\tb: 2", "scene.yaml:2: not valid YAML"),
        ("a: !!python/object/apply:os.system [ls]", "scene.yaml:1: not valid YAML: could not determine a constructor"),
        ("a: 2024-13-45", "scene.yaml: not valid YAML"),
        ("a: &a [*a]", "scene.yaml:1: an alias stands inside its own anchor"),
        ("a: *b", "scene.yaml:1: not valid YAML: found undefined alias"),
        ("? [1, 2]\n: 3", "scene.yaml:1: expected a plain word as a key"),
        ("a: 1\n---\nb: 2", "scene.yaml:2: not valid YAML"),
        ("a: \x07", "scene.yaml: not valid YAML"),
        ("- 1\n- 2", "scene.yaml: expected a mapping of keys to values, got a list"),
        ("", "scene.yaml: expected a mapping of keys to values, got an empty file"),
    ],
)
def test_bad_yaml_is_one_line_with_file_and_line(text, message):
    with pytest.raises(ValueError, match=r"scene\.yaml") as failure:
        parse_yaml(text, PATH)
    assert str(failure.value).startswith(message)
    assert "\n" not in str(failure.value)


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "x.yaml"
    path.write_bytes(b"a: \xff\xfe")
    with pytest.raises(ValueError, match="expected UTF-8 text, got byte 0xff"):
        read_yaml(path)
    with pytest.raises(ValueError, match="got a folder"):
        read_yaml(tmp_path)
    with pytest.raises(ValueError, match="no such file"):
        read_yaml(tmp_path / "y.yaml")
