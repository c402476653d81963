"""Checks that estimators make of their parameters: each names the parameter and what came in."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf
from typing import Any

import numpy as np


def is_number(value: object) -> bool:
    """Whether a value is a real number and no truth value."""
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def whole_number(name: str, value: Any, least: int) -> int:
    """`value` as an int; ValueError unless it is a whole number of at least `least`."""
    if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value < least:
        raise ValueError(f"{name} must be a whole number of at least {least}, got {value!r}.")
    return int(value)


def positive(name: str, value: Any) -> None:
    """ValueError unless `value` is a number above 0 and below infinity."""
    if not is_number(value) or not 0 < value < inf:
        raise ValueError(f"{name} must be positive and finite, got {value!r}.")


def not_negative(name: str, value: Any) -> None:
    """ValueError unless `value` is a number of at least 0 and below infinity."""
    if not is_number(value) or not 0 <= value < inf:
        raise ValueError(f"{name} must be finite and not negative, got {value!r}.")


def share(name: str, value: Any) -> None:
    """ValueError unless `value` is a number from 0 to 1."""
    if not is_number(value) or not 0 <= value <= 1:
        raise ValueError(f"{name} must lie in 0 to 1, got {value!r}.")


def check_jobs(n_jobs: Any) -> None:
    """ValueError unless `n_jobs` is None or a whole number other than 0."""
    if n_jobs is not None and (not isinstance(n_jobs, (int, np.integer)) or isinstance(n_jobs, bool) or n_jobs == 0):
        raise ValueError(f"n_jobs must be None or a whole number other than 0 (-1: all cores), got {n_jobs!r}.")


def check_known(what: str, names: Iterable[Any], known: Iterable[Any], group: str = "modalities") -> None:
    """ValueError where one of `names` is not among those `known`; `what` begins the message, as "weights name"."""
    there = list(known)
    unknown = [name for name in names if name not in there]
    if unknown:
        raise ValueError(f"{what} {joined(unknown)}; the {group} are {joined(there)}.")


def joined(names: Iterable[Any]) -> str:
    """Names in one text, whatever they are."""
    return ", ".join(str(name) for name in names)
