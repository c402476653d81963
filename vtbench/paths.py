"""Where vtbench finds its own configurations and keeps its cache."""

import os
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def configs_dir() -> Path:
    """Folder that holds `scenes/`, `tasks/` and `suites/`.

    An installed wheel carries it as `vtbench/_configs`; in a clone it stands beside the packages.

    Raises:
        ValueError: neither exists, so the installation is incomplete.
    """
    for folder in (_PACKAGE / "_configs", _PACKAGE.parent / "configs"):
        if folder.is_dir():
            return folder
    raise ValueError(f"no configurations beside {_PACKAGE}: the installation is incomplete, install vtbench again")


def cache_dir() -> Path:
    """Folder for downloads and other things that can be made again: `VTBENCH_CACHE`, else the user's cache.

    It is not created here.
    """
    chosen = os.environ.get("VTBENCH_CACHE")
    if chosen:
        return Path(chosen).expanduser()
    import platformdirs

    return Path(platformdirs.user_cache_dir("vtbench"))
