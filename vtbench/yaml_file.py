"""Strict YAML: safe types only, no key twice, and the line of every key for error messages."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

KeyPath = tuple[str | int, ...]


@dataclass(frozen=True)
class YamlFile:
    """What a YAML file holds.

    Attributes:
        path: the file.
        data: its top-level mapping.
        lines: line number, from 1, of each key path.
    """

    path: Path
    data: dict[str, Any]
    lines: dict[KeyPath, int]


class _StrictLoader(yaml.SafeLoader):
    """`SafeLoader` that reads `1e-3` as a number (YAML 1.2), not a string."""


_StrictLoader.yaml_implicit_resolvers = {
    first: list(resolvers) for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_StrictLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"), list("-+0123456789")
)


def read_yaml(path: Path) -> YamlFile:
    """Read a YAML file whose top level is a mapping.

    Raises:
        ValueError: not there, not text, not YAML, a key given twice, or no mapping; names file and line.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise ValueError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise ValueError(f"{path}: expected a YAML file, got a folder") from None
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: expected UTF-8 text, got byte {error.object[error.start]:#04x}") from None
    return parse_yaml(text, path)


def parse_yaml(text: str, path: Path) -> YamlFile:
    """As `read_yaml`, from text; `path` is only named in errors."""
    lines: dict[KeyPath, int] = {}
    loader = None
    try:
        loader = _StrictLoader(text)
        node = loader.get_single_node()
        if node is not None:
            _walk(node, (), lines, ())
        data = loader.construct_document(node) if node is not None else None
    except yaml.YAMLError as error:
        raise ValueError(f"{path}{_where(error)}: {_what(error)}") from None
    except ValueError as error:  # e.g. the date 2024-13-45
        raise ValueError(f"{path}: not valid YAML: {error}") from None
    finally:
        if loader is not None:
            loader.dispose()
    if not isinstance(data, dict):
        got = "an empty file" if data is None else f"a {type(data).__name__}"
        raise ValueError(f"{path}: expected a mapping of keys to values, got {got}")
    return YamlFile(path, data, lines)


_MERGE = "tag:yaml.org,2002:merge"


def _walk(node: yaml.Node, at: KeyPath, lines: dict[KeyPath, int], inside: tuple[yaml.Node, ...]) -> None:
    """Note the line of each key below `node`; refuse a key given twice and an alias inside its own anchor."""
    if any(node is outer for outer in inside):
        raise _problem("an alias stands inside its own anchor", node)
    inside = (*inside, node)
    if isinstance(node, yaml.SequenceNode):
        for index, item in enumerate(node.value):
            # a merge list, `<<: [*a, *b]`, adds its mappings' keys to the mapping that it stands in
            below = at[:-1] if at and at[-1] == _MERGE else (*at, index)
            lines.setdefault(below, item.start_mark.line + 1)
            _walk(item, below, lines, inside)
    elif isinstance(node, yaml.MappingNode):
        at = at[:-1] if at and at[-1] == _MERGE else at
        first: dict[str, int] = {}
        for key, value in sorted(node.value, key=lambda pair: pair[0].tag != _MERGE):
            if key.tag == _MERGE:
                _walk(value, (*at, _MERGE), lines, inside)
                continue
            line = key.start_mark.line + 1
            if not isinstance(key, yaml.ScalarNode):
                raise _problem("expected a plain word as a key", key)
            if key.value in first:
                raise _problem(f"key {key.value!r} is given twice, first on line {first[key.value]}", key)
            first[key.value] = line
            lines[(*at, key.value)] = line
            _walk(value, (*at, key.value), lines, inside)


def _problem(text: str, node: yaml.Node) -> yaml.MarkedYAMLError:
    return yaml.MarkedYAMLError(problem=text, problem_mark=node.start_mark)


def _where(error: yaml.YAMLError) -> str:
    mark = getattr(error, "problem_mark", None)
    return f":{mark.line + 1}" if mark is not None else ""


def _what(error: yaml.YAMLError) -> str:
    problem = getattr(error, "problem", None) or " ".join(str(error).split())
    return problem if type(error) is yaml.MarkedYAMLError else f"not valid YAML: {problem}"
