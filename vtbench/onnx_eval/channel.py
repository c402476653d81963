"""Messages from the locked process: a line of JSON, then as many bytes as it announces; all of it bounded."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from typing import Any

LONGEST_HEADER = 64_000


class BrokenMessageError(ValueError):
    """Something came that is no message, or more of it than was agreed."""


def send(handle: int, header: dict[str, Any], payload: bytes | memoryview = b"") -> None:
    """Write one message; blocks until it is all taken."""
    line = json.dumps({**header, "bytes": len(payload)}).encode() + b"\n"
    for part in (line, payload):
        left = memoryview(part)
        while left:
            left = left[os.write(handle, left) :]


class Reader:
    """Takes bytes as they come and gives whole messages.

    Raises BrokenMessageError as soon as more than `most` bytes came, or a header is too long or malformed.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._seen = 0
        self._buffer = bytearray()
        self._header: dict[str, Any] | None = None

    def feed(self, data: bytes) -> Iterator[tuple[dict[str, Any], bytes]]:
        """Yield the messages that `data` completes."""
        self._seen += len(data)
        if self._seen > self._most:
            raise BrokenMessageError(f"it sent more than the {self._most} bytes that were agreed")
        self._buffer += data
        while True:
            if self._header is None and not self._take_header():
                return
            assert self._header is not None
            wanted = self._header["bytes"]
            if len(self._buffer) < wanted:
                return
            message = self._header, bytes(self._buffer[:wanted])
            del self._buffer[:wanted]
            self._header = None
            yield message

    def _take_header(self) -> bool:
        end = self._buffer.find(b"\n")
        if end < 0:
            if len(self._buffer) > LONGEST_HEADER:
                raise BrokenMessageError("it sent a header without end")
            return False
        try:
            header = json.loads(self._buffer[:end])
        except (ValueError, RecursionError):
            raise BrokenMessageError("it sent a header that is no JSON") from None
        size = header.get("bytes") if isinstance(header, dict) else None
        if not isinstance(size, int) or isinstance(size, bool) or not 0 <= size <= self._most:
            raise BrokenMessageError("it sent a header without a size, or with an impossible one")
        del self._buffer[: end + 1]
        self._header = header
        return True
