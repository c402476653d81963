"""Files that are whole or absent: write under a temporary name, flush to the disk, then rename."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

_TEMPORARY = ".tmp"


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a temporary file beside `path`, then put it in place in one step.

    Killed at any point, `path` is either the file it was before or the whole new one. When `write` or the
    disk fails, the temporary file is removed and the error raised, an OSError with the name of `path`; what was
    there stays.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}{_TEMPORARY}")
    try:
        write(temporary)
        with temporary.open("rb") as file:
            os.fsync(file.fileno())
        os.replace(temporary, path)
        _sync_folder(path.parent)
    except OSError as error:
        raise _not_written(path, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def _not_written(path: Path, error: OSError) -> OSError:
    """The error of a file that could not be written: libraries name the temporary file, or none, or say no reason."""
    if error.filename not in (None, str(path.with_name(f".{path.name}.{os.getpid()}{_TEMPORARY}"))):
        return error
    if error.errno is None:  # NumPy's count of what was written
        return OSError(f"{path}: cannot be written whole ({error}); is the disk full? What was there is as it was")
    return OSError(error.errno, f"{os.strerror(error.errno)}; what was there is as it was", str(path))


def write_text(path: Path, text: str) -> None:
    """`write_whole` for UTF-8 text."""
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def is_temporary(path: Path) -> bool:
    """Whether a file is one that a killed writer left behind."""
    return path.name.startswith(".") and path.name.endswith(_TEMPORARY)


def remove_temporaries(folder: Path) -> None:
    """Delete what writers that were killed left behind in `folder`; what one that lives is writing stays."""
    for path in folder.glob(f".*{_TEMPORARY}"):
        if not _written_now(path):
            path.unlink(missing_ok=True)


def _written_now(path: Path) -> bool:
    """Whether the process that a temporary name ends in is another one that lives on this machine."""
    number = path.name.removesuffix(_TEMPORARY).rpartition(".")[2]
    if os.name != "posix" or not number.isdecimal() or int(number) == os.getpid():
        return False
    try:
        os.kill(int(number), 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        pass
    return True


def sha256_of(path: Path) -> str:
    """SHA-256 of a file's bytes, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def make_folder(path: Path) -> None:
    """Create `path` and check that files can be written in it; OSError of one line when not."""
    probe = path / f".writable.{os.getpid()}{_TEMPORARY}"
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        reason = error.strerror or str(error)
        raise OSError(f"{path}: cannot write here ({reason}); choose a folder that is writable") from error


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Hold `folder` for this process; OSError when another one holds it (no-op where locks do not exist)."""
    try:
        import fcntl
    except ImportError:  # not a POSIX system
        yield
        return
    lock = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OSError(f"{folder}: another process is writing this dataset; wait until it ends") from None
        yield
    finally:
        os.close(lock)


def _sync_folder(folder: Path) -> None:
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
