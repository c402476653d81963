"""Loops over time that array operations cannot do, compiled by numba at their first call and cached on disk."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Decorator: compile at the first call, so that importing a module neither loads numba nor compiles.

    Only plain loops over NumPy arrays and scalars; no fast-math, so the values are those of the same Python.
    """
    kernel: Callable[..., Any] | None = None

    @wraps(function)
    def run(*arguments: Any) -> Any:
        nonlocal kernel
        if kernel is None:
            kernel = _compile(function)
        return kernel(*arguments)

    return cast(F, run)


def _compile(function: Callable[..., Any]) -> Callable[..., Any]:
    import numba

    try:
        return cast(Callable[..., Any], numba.njit(cache=True, nogil=True)(function))
    except RuntimeError:  # nowhere to keep the cache, as in a read-only installation
        return cast(Callable[..., Any], numba.njit(nogil=True)(function))
