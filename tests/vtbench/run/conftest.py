"""One small dataset for all tests of a run; no test changes it."""

import pytest

from tests.vtbench.run import small


@pytest.fixture(scope="session")
def presses(tmp_path_factory):
    """Folder of a dataset of 48 presses."""
    return small.write(tmp_path_factory.mktemp("presses") / "set")


@pytest.fixture
def log(tmp_path):
    """File in which `Nearest` leaves one line a fit, and a function that counts them."""
    path = tmp_path / "fits.txt"

    def count():
        return len(path.read_text().splitlines()) if path.exists() else 0

    count.path = str(path)
    return count
