"""Names to parts, with versioned ids (`objects/deep/v1`) and a close match for a misspelt one."""

import difflib
import re
from collections.abc import Callable, Iterable, Iterator
from typing import Generic, TypeVar

T = TypeVar("T")

_ID = re.compile(r"[a-z0-9][a-z0-9_.+-]*(/[a-z0-9][a-z0-9_.+-]*)*")
_LISTED = 8


def close_matches(word: str, choices: Iterable[str], count: int = 3) -> list[str]:
    """The choices most like `word`, best first; empty when none is close.

    Case does not count; a choice that `word` begins or ends is close (`objects/deep` for `objects/deep/v1`).
    """
    by_lower = {choice.lower(): choice for choice in choices}
    lower = word.lower()
    found = [key for key in by_lower if lower and (key.startswith(lower) or key.endswith(lower))]
    found.sort(key=len)
    found += [key for key in difflib.get_close_matches(lower, by_lower, n=count, cutoff=0.6) if key not in found]
    return [by_lower[key] for key in found[:count]]


def hint(word: str, choices: Iterable[str]) -> str:
    """`; did you mean 'x'?`, or the choices themselves when none is close and they are few, else empty."""
    known = list(choices)
    near = close_matches(word, known)
    if near:
        return "; did you mean " + " or ".join(repr(name) for name in near) + "?"
    if 0 < len(known) <= _LISTED:
        return "; known: " + ", ".join(known)
    return ""


def unknown(kind: str, word: str, choices: Iterable[str], see: str = "") -> ValueError:
    """The error for a name that is not there: unknown scene 'x'; did you mean 'y'? (`vtbench list scenes`)."""
    return ValueError(f"unknown {kind} {word!r}{hint(word, choices)}" + (f" (`{see}`)" if see else ""))


class Registry(Generic[T]):
    """Parts of one kind under their ids, in the order in which they were registered.

    Args:
        kind: what the parts are, as an error message names them (`task`).
        see: command that lists them, added to the error for an unknown id.
    """

    def __init__(self, kind: str, see: str = "") -> None:
        self.kind = kind
        self.see = see
        self._parts: dict[str, T] = {}

    def register(self, part_id: str) -> Callable[[T], T]:
        """Decorator, or a function to call on a part: `REGISTRY.register("objects/deep/v1")(part)`.

        Raises:
            ValueError: the id is malformed or already taken.
        """
        if not _ID.fullmatch(part_id):
            raise ValueError(
                f"{self.kind} id {part_id!r}: expected lower-case words and '/', such as 'objects/deep/v1'"
            )
        if part_id in self._parts:
            raise ValueError(f"{self.kind} id {part_id!r} is registered twice: give the new part its own id")

        def keep(part: T) -> T:
            self._parts[part_id] = part
            return part

        return keep

    def get(self, part_id: str) -> T:
        """The part with this id.

        Raises:
            ValueError: no such id; the message carries the closest ones.
        """
        try:
            return self._parts[part_id]
        except KeyError:
            raise unknown(self.kind, part_id, self._parts, self.see) from None

    def ids(self) -> tuple[str, ...]:
        """All ids, in the order of registration."""
        return tuple(self._parts)

    def items(self) -> tuple[tuple[str, T], ...]:
        """All (id, part) pairs, in the order of registration."""
        return tuple(self._parts.items())

    def __contains__(self, part_id: object) -> bool:
        return part_id in self._parts

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)
