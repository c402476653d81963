"""A SIGTERM or Ctrl-C that compiled code turned into another error."""

from __future__ import annotations


def raise_interruption(error: BaseException) -> None:
    """Raise the `KeyboardInterrupt` that `error` came of; nothing where it came of none.

    A signal that arrives while compiled code converts its arguments shows as a `SystemError` caused by what the
    signal's handler raised.
    """
    seen: BaseException | None = error if isinstance(error, SystemError) else None
    while seen is not None:
        if isinstance(seen, KeyboardInterrupt):
            raise seen
        seen = seen.__cause__ or seen.__context__
