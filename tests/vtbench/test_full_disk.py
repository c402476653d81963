"""A disk that is full: one line that names the file, exit code 2, and what was there as it was."""

from contextlib import contextmanager

import pytest
import yaml

from tests.vtbench.run import small

resource = pytest.importorskip("resource")
SMALL = 20_000
"""Bytes that a file may have while the disk is `full`; suites and records are smaller, data and pages are not."""


@contextmanager
def full(most=SMALL):
    """The kernel refuses every byte of a file beyond `most`, for whatever library writes it."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def refused(answer, name):
    """One line that names the file and says why, and no leaves."""
    assert answer.code == 2, answer
    (line,) = answer.err.strip().splitlines()
    assert name in line
    assert "File too large" in line or "cannot be written whole" in line
    assert "what was there is as it was" in line.lower()
    assert ".tmp" not in line


@pytest.fixture(scope="module")
def presses(tmp_path_factory):
    return small.write(tmp_path_factory.mktemp("presses") / "set")


@pytest.fixture
def suite(presses, tmp_path):
    def write(*modalities):
        entry = {"modalities": list(modalities), "splits": ["random"]}
        made = small.suite(presses, entry=entry, backbone="pixels").model_dump(mode="json")
        (tmp_path / "suite.yaml").write_text(yaml.safe_dump(made), encoding="utf-8")
        return tmp_path / "suite.yaml"

    return write


def test_generate_goes_on_where_the_disk_was_full(vtbench, tmp_path):
    words = ("generate", "fvsight-press", "--samples", "4", "-o", tmp_path / "set")
    with full():
        refused(vtbench(*words), "set/shard-00000.parquet")
    assert [path.name for path in (tmp_path / "set").iterdir()] == ["dataset.partial.json"]
    assert vtbench(*words).code == 0
    assert vtbench("validate", tmp_path / "set").code == 0


def test_run_keeps_its_records_and_goes_on(vtbench, suite, tmp_path):
    out = tmp_path / "run"
    assert vtbench("run", suite("force"), "-o", out).code == 0
    before = contents(out / "runs")
    with full():
        refused(vtbench("run", suite("force", "image"), "-o", out), ".npy")
    assert contents(out / "runs") == before
    assert not list(out.rglob(".*.tmp"))
    assert vtbench("run", suite("force", "image"), "-o", out).code == 0
    after = contents(out / "runs")
    assert after.items() > before.items()


def test_board_and_export_leave_what_was_drawn_and_exported(vtbench, suite, presses, tmp_path):
    out = tmp_path / "run"
    assert vtbench("run", suite("force"), "-o", out).code == 0
    assert vtbench("board", out, "-o", tmp_path / "board").code == 0
    page = tmp_path / "board/index.html"
    drawn = page.read_bytes()
    with full(len(drawn) // 2):
        refused(vtbench("board", out, "-o", tmp_path / "board"), "board/index.html")
    assert page.read_bytes() == drawn
    assert not list((tmp_path / "board").rglob(".*.tmp"))

    made = tmp_path / "net.onnx"
    made.write_bytes(b"what was there")
    feed = ("--modality", "image", "--variant", "own", "--backbone", "pixels", "--features", tmp_path / "features")
    words = ("export", "objects/interference/v1", "knn", *feed, "--data", presses, "-o", made)
    with full():
        refused(vtbench(*words), ".npy")  # the features come first
    assert made.read_bytes() == b"what was there"
    assert vtbench(*words).code == 0
    exported = made.read_bytes()
    assert len(exported) > SMALL
    with full():
        refused(vtbench(*words), "net.onnx")
    assert made.read_bytes() == exported
