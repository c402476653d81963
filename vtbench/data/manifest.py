"""Lists of files with their SHA-256, one `<sha256>  <path>` a line, as `sha256sum` writes and checks them."""

from __future__ import annotations

import re
from pathlib import Path

from vtbench.data.files import sha256_of

_LINE = re.compile(r"([0-9a-f]{64})  (\S.*)")


def manifest_of(root: Path, pattern: str) -> str:
    """Manifest of the files below `root` that match the glob `pattern`, sorted by path.

    How a committed manifest was made: `manifest_of(Path("FabricSlide"), "data/*/*.csv")` on a checkout of the
    pinned commit.
    """
    paths = sorted(path.relative_to(root).as_posix() for path in root.glob(pattern) if path.is_file())
    return "".join(f"{sha256_of(root / path)}  {path}\n" for path in paths)


def read_manifest(path: Path) -> dict[str, str]:
    """Relative path -> SHA-256; ValueError names a line that is not of that form."""
    files = {}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        match = _LINE.fullmatch(line)
        if match is None or ".." in Path(match[2]).parts or Path(match[2]).is_absolute():
            raise ValueError(f"{path}, line {number}: expected '<sha256>  <relative path>', got {line!r}")
        files[match[2]] = match[1]
    return files


def wrong_files(root: Path, files: dict[str, str]) -> list[str]:
    """Those of `files` that are missing below `root` or whose checksum is off."""
    return [path for path, sha256 in files.items() if not (root / path).is_file() or sha256_of(root / path) != sha256]
