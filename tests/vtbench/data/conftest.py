"""Real recordings for tests, where they are."""

import os
from pathlib import Path

import pytest

_CHOSEN = os.environ.get("VTBENCH_DATA")


@pytest.fixture
def real_recordings():
    """Folder of a public set below `VTBENCH_DATA`; skips where it is not."""

    def root(name):
        if not _CHOSEN or not (Path(_CHOSEN) / name).is_dir():
            pytest.skip(f"no recordings: set VTBENCH_DATA to the folder that holds {name}/")
        return Path(_CHOSEN) / name

    return root
