"""Pydantic's verdict on a configuration, in one line: file, line, key, what was expected, what came."""

import dataclasses
import typing
from collections.abc import Mapping, Sequence
from typing import Any

import pydantic

from vtbench.registry import hint
from vtbench.yaml_file import KeyPath

_UNKNOWN_KEY = ("extra_forbidden", "unexpected_keyword_argument")
_NO_MAPPING = ("model_type", "dataclass_type", "model_attributes_type")
_MISSING_KEY = ("missing", "missing_argument", "missing_keyword_only_argument")
_WORDS = (
    ("expected a valid ", "expected a "),
    ("expected a integer", "expected an integer"),
    ("expected greater", "expected a value greater"),
    ("expected less", "expected a value less"),
)
_SHOWN = 60


def one_line(
    error: pydantic.ValidationError,
    model: Any,
    data: Any,
    source: str = "",
    lines: Mapping[KeyPath, int] | None = None,
) -> str:
    """The first problem of a `ValidationError` and the count of further ones.

    Args:
        error: what pydantic raised.
        model: the model that refused the data; its fields give the close match for an unknown key.
        data: what was validated.
        source: file that the data came from, to begin the line with.
        lines: line number of each key path in that file.
    """
    problems = _problems(error)
    # a misspelt key is also a missing one: what was written comes before what was not
    first = min(problems, key=lambda problem: problem["type"] in _MISSING_KEY)
    at = _in_data(first["loc"], data)
    line = _nearest_line(at, lines or {})
    where = f"{source}:{line}" if source and line else source
    parts = [where, dotted(at), _explain(first, model, data)]
    others = len({_in_data(problem["loc"], data) for problem in problems} - {at})
    more = f" (and {others} more problem{'s' if others > 1 else ''})" if others else ""
    return ": ".join(part for part in parts if part) + more


def every_line(
    error: pydantic.ValidationError, model: Any, data: Any, lines: Mapping[KeyPath, int] | None = None
) -> list[str]:
    """Every problem of a `ValidationError`, one line each, by line and key; for checkers that list them all."""
    found: dict[KeyPath, str] = {}
    for problem in _problems(error):
        at = _in_data(problem["loc"], data)
        line = _nearest_line(at, lines or {})
        where = f"line {line}" if line else ""
        parts = (where, dotted(at), _explain(problem, model, data))
        found.setdefault(at, ": ".join(part for part in parts if part))
    return list(found.values())


def _problems(error: pydantic.ValidationError) -> list[Any]:
    """Every problem; not of a list that an item's refusal left too short."""
    found = error.errors(include_url=False)

    def follows(problem: Any) -> bool:
        depth = len(problem["loc"])
        return problem["type"] == "too_short" and any(
            len(each["loc"]) > depth and each["loc"][:depth] == problem["loc"] for each in found
        )

    return [problem for problem in found if not follows(problem)]


def dotted(at: Sequence[str | int]) -> str:
    """A key path as one reads it: `entries[0].methods`."""
    text = ""
    for part in at:
        text += f"[{part}]" if isinstance(part, int) else (f".{part}" if text else str(part))
    return text


def _explain(problem: Any, model: Any, data: Any) -> str:
    kind, context, got = problem["type"], problem.get("ctx", {}), problem["input"]
    if kind in _UNKNOWN_KEY:
        *parents, key = problem["loc"]
        return f"unknown key{hint(str(key), _fields_at(model, parents))}"
    if kind in _MISSING_KEY:
        return "expected this key, got nothing"
    if kind in ("value_error", "assertion_error"):
        return str(context.get("error", problem["msg"])).strip()
    if kind in _NO_MAPPING and (fields := _fields_at(model, problem["loc"])):
        return f"expected a mapping of {', '.join(fields)}, got {_short(got)}"
    if kind == "too_short":
        least = context["min_length"]
        return f"expected at least {least} item{'s' if least > 1 else ''}, got {_short(got)}"
    if kind in ("tuple_type", "list_type"):
        like = "" if isinstance(got, Mapping | str | None) else f" such as [{_short(got)}]"
        return f"expected a list{like}, got {_short(got)}"
    expected = problem["msg"].replace("Input should be", "expected", 1).split(", unable to parse")[0]
    for theirs, ours in _WORDS:
        expected = expected.replace(theirs, ours, 1)
    if kind in ("literal_error", "enum"):
        choices = context.get("expected", "").replace("'", "").replace(" or ", ", ").split(", ")
        near = hint(str(got), choices)
        return f"{expected}, got {_short(got)}" + (near if near.startswith("; did") else "")
    return f"{expected}, got {_short(got)}"


def _short(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"a mapping with {', '.join(map(str, list(value)[:4])) or 'no keys'}"
    text = repr(value)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."


def _in_data(location: Sequence[str | int], data: Any) -> KeyPath:
    """The part of pydantic's location that is a key path in the data: without the tags of union members."""
    at: list[str | int] = []
    for index, part in enumerate(location):
        items: Any = dict(enumerate(data)) if isinstance(data, list | tuple) else data
        if isinstance(items, Mapping) and part in items:
            data = items[part]
        elif index < len(location) - 1 or not isinstance(data, Mapping):
            continue
        at.append(part)
    return tuple(at)


def _nearest_line(at: KeyPath, lines: Mapping[KeyPath, int]) -> int | None:
    """Line of the key, else of the closest key above it that stands in the file; 0 or None: not in the file."""
    for end in range(len(at), 0, -1):
        if at[:end] in lines:
            return lines[at[:end]]
    return None


def _fields_at(model: Any, parents: Sequence[str | int]) -> list[str]:
    """Names that a mapping at this place may hold, over all members of a union."""
    classes = _classes(model)
    for part in parents:
        below = [fields[str(part)] for fields in map(_fields, classes) if part in fields]
        if below:
            classes = [cls for annotation in below for cls in _classes(annotation)]
    return list(dict.fromkeys(name for cls in classes for name in _fields(cls)))


def _fields(cls: type) -> dict[str, Any]:
    if issubclass(cls, pydantic.BaseModel):
        return {info.alias or name: info.annotation for name, info in cls.model_fields.items()}
    return dict(typing.get_type_hints(cls))


def _classes(annotation: Any) -> list[type]:
    """Models and dataclasses inside an annotation such as `dict[str, list[A | B]]`."""
    if isinstance(annotation, type) and (
        issubclass(annotation, pydantic.BaseModel) or dataclasses.is_dataclass(annotation)
    ):
        return [annotation]
    return [cls for inner in typing.get_args(annotation) for cls in _classes(inner)]
