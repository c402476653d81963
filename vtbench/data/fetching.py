"""Download public recordings: pinned, every file checked, whole or absent, resumed after a failure."""

from __future__ import annotations

import hashlib
import http.client
import os
import shutil
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from vtbench.data.files import make_folder, write_whole
from vtbench.data.manifest import wrong_files
from vtbench.data.public import PublicSet, cached_root, public_set

_TRIES = 3
_PAUSE_S = 0.5
_TIMEOUT_S = 30.0
_CONNECTIONS = 8


def fetch(name: str, *, progress: bool = True) -> Path:
    """Bring the public recordings `name` into the cache and return their folder; no work when they are there.

    Raises:
        ValueError: unknown name, or a file that is not the one that was pinned.
        OSError: no network, or the cache cannot be written; files that came stay for the next try.
    """
    source, root = public_set(name), cached_root(name)
    if source.unpack is None:
        return fetch_set(source, root, progress=progress)
    return root if root.is_dir() else _fetch_and_unpack(source, source.unpack, root, progress)


def _fetch_and_unpack(source: PublicSet, unpack: Callable[[Path, Path], None], root: Path, progress: bool) -> Path:
    """`fetch_set`, then the set from what came; `root` appears whole, the download goes."""
    download, work = root.with_name(f".{root.name}.download"), root.with_name(f".{root.name}.unpacked")
    fetch_set(source, download, progress=progress)
    shutil.rmtree(work, ignore_errors=True)
    unpack(download, work)
    os.replace(work, root)
    shutil.rmtree(download)
    return root


def fetch_set(source: PublicSet, root: Path, *, progress: bool = True) -> Path:
    """Bring the files of `source` to the folder `root`, which appears when all of them are there."""
    from tqdm import tqdm

    work = root if root.is_dir() else root.with_name(f".{root.name}.partial")
    make_folder(work)
    missing = wrong_files(work, source.files)
    hidden = None if progress else True  # None: shown on a terminal only
    with (
        ThreadPoolExecutor(_CONNECTIONS) as pool,
        tqdm(total=len(source.files), desc=source.name, unit="file", file=sys.stderr, disable=hidden) as bar,
    ):
        bar.update(len(source.files) - len(missing))
        try:
            for done in as_completed([pool.submit(_bring, source, path, work) for path in missing]):
                done.result()
                bar.update()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    if work != root:
        os.replace(work, root)
    return root


def _bring(source: PublicSet, path: str, root: Path) -> None:
    url = f"{source.base_url}/{urllib.parse.quote(path)}"
    data = _download(url, source.name)
    if (found := hashlib.sha256(data).hexdigest()) != source.files[path]:
        raise ValueError(
            f"{url}: checksum is off: SHA-256 {found[:12]}..., expected {source.files[path][:12]}...; "
            "not kept, what came before is; try again, and report it when it stays"
        )
    (root / path).parent.mkdir(parents=True, exist_ok=True)
    write_whole(root / path, lambda temporary: temporary.write_bytes(data))


def _download(url: str, name: str) -> bytes:
    """The bytes at `url`; what may pass is tried again, then OSError of one line."""
    for attempt in range(1, _TRIES + 1):
        try:
            with urllib.request.urlopen(url, timeout=_TIMEOUT_S) as answer:
                data: bytes = answer.read()
                return data
        except (OSError, http.client.HTTPException) as error:
            if _final(error) or attempt == _TRIES:
                raise OSError(
                    f"cannot download {url} ({_reason(error)}); check the network and run `vtbench fetch {name}` again "
                    f"(files that came are kept), or set VTBENCH_DATA to a folder that holds {name}/"
                ) from error
            time.sleep(_PAUSE_S * attempt)
    raise AssertionError("unreachable")


def _final(error: Exception) -> bool:
    """Would the same request fail again? Closes the answer that came."""
    if not isinstance(error, urllib.error.HTTPError):
        return False
    error.close()
    return 400 <= error.code < 500 and error.code != 429


def _reason(error: Exception) -> str:
    text = " ".join(str(getattr(error, "reason", "") or error or type(error).__name__).split())
    return f"HTTP {error.code} {text}" if isinstance(error, urllib.error.HTTPError) else text
