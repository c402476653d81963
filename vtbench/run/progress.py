"""A bar on standard error, where that is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def bar(total: int, label: str, shown: bool) -> Iterator[Callable[[int], None]]:
    """Yield a function that moves the bar on by a count."""
    if not shown or not sys.stderr.isatty():
        yield lambda count: None
        return
    from tqdm import tqdm

    with tqdm(total=total, desc=label, leave=False, dynamic_ncols=True) as line:

        def advance(count: int) -> None:
            line.update(count)

        yield advance
