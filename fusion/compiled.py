"""How the package compiles its loops: numba, kept on disk, the interpreter's lock released."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numba import njit

F = TypeVar("F", bound=Callable[..., object])

# A whole number that indexes without the check for negative ones: loops over such a range vectorise.
unsigned: Callable[[int], int] = np.uint64  # type: ignore[assignment]


def compiled(function: F) -> F:
    """`function` as machine code of IEEE arithmetic, order of operations kept.

    The code is cached beside the module or, where that folder is read-only, in the user's cache; where
    neither can be written, it is compiled anew in each process. The cache knows the function's own file only:
    after a change in a function that another file calls, delete the cached code, `__pycache__/*.nb[ci]`.
    """
    try:
        return njit(nogil=True, cache=True)(function)
    except RuntimeError:  # numba found no folder that it may write
        return njit(nogil=True)(function)
