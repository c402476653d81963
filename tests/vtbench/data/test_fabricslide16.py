"""Sliding recordings: every count as the files give it, from the files and from the cache."""

import csv
import os

import numpy as np
import pytest

from vtbench.data import load_fabricslide16
from vtbench.data.counts_cache import read_counts
from vtbench.data.fabricslide16 import COLUMNS, PERIOD_MS

NAMES = ("Canvas_F120_V-10mmps_0", "Canvas_F120_V30mmps_2", "Linen_F250_V-150mmps_1")


@pytest.fixture
def root(tmp_path, monkeypatch):
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path / "cache"))
    rng = np.random.default_rng(0)
    (tmp_path / "set/data/fabric").mkdir(parents=True)
    for number, name in enumerate(NAMES):
        counts = rng.integers(0, 65536, (5 + number, len(COLUMNS)))
        lines = [", ".join(COLUMNS), *(",".join(map(str, row)) for row in counts)]
        ending = "\r\n" if number == 1 else "\n"
        text = ending.join(lines) + ("" if number == 2 else ending)
        (tmp_path / f"set/data/fabric/{name}.csv").write_bytes(text.encode())
    return tmp_path / "set"


def by_hand(path):
    with path.open(newline="") as file:
        return np.array([[float(cell) for cell in row] for row in list(csv.reader(file))[1:]])


def check(recordings, root, indices):
    for index in indices:
        values = by_hand(root / recordings.path[index])
        np.testing.assert_array_equal(recordings.time_ms[index], values[:, 0])
        np.testing.assert_array_equal(recordings.proximity[index], values[:, 1:3])
        np.testing.assert_array_equal(recordings.series[index], values[:, 3:])


def test_counts_and_conditions_come_from_the_files(root):
    recordings = load_fabricslide16(root)
    check(recordings, root, range(3))
    assert list(recordings.fabric) == ["Canvas", "Canvas", "Linen"]
    assert list(recordings.setting) == [120, 120, 250]
    assert list(recordings.speed) == [-10, 30, -150]
    assert list(recordings.repetition) == [0, 2, 1]


def test_the_cache_gives_the_same_and_notices_a_changed_file(root, tmp_path):
    first = load_fabricslide16(root)
    again = load_fabricslide16(root)
    for attribute in ("series", "proximity", "time_ms"):
        for a, b in zip(getattr(first, attribute), getattr(again, attribute), strict=True):
            np.testing.assert_array_equal(a, b)
    path = root / first.path[0]
    path.write_bytes(path.read_bytes() + b",".join([b"7"] * len(COLUMNS)) + b"\n")
    assert len(load_fabricslide16(root).series[0]) == 6


def test_the_second_time_the_files_are_not_read(root):
    first = load_fabricslide16(root)
    path = root / first.path[0]
    kept = path.stat()
    path.write_bytes(path.read_bytes().replace(b"1", b"2"))
    os.utime(path, ns=(kept.st_atime_ns, kept.st_mtime_ns))
    np.testing.assert_array_equal(load_fabricslide16(root).series[0], first.series[0])


@pytest.mark.parametrize("damage", [b"", b"not a cache", b"PK\x03\x04"])
def test_a_damaged_cache_is_made_again(root, tmp_path, damage):
    load_fabricslide16(root)
    (cache,) = (tmp_path / "cache/parsed").iterdir()
    cache.write_bytes(damage)
    check(load_fabricslide16(root), root, range(3))


def test_an_unwritable_cache_costs_nothing_but_time(root, tmp_path, monkeypatch):
    monkeypatch.setenv("VTBENCH_CACHE", str(root / "data/fabric" / f"{NAMES[0]}.csv"))
    check(load_fabricslide16(root), root, range(3))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("timestamp, proximity1\n1,2\n", "expected the columns timestamp, .*, got timestamp, proximity1"),
        (", ".join(COLUMNS) + "\n" + ",".join(["1"] * 18) + "\n", "Expected 19 columns, got 18"),
        (", ".join(COLUMNS) + "\n" + ",".join(["1"] * 18 + ["nan"]) + "\n", "'nan'"),
        (", ".join(COLUMNS) + "\n", "no samples below the heading"),
        ("", "expected the columns"),
    ],
)
def test_a_file_of_another_form_is_named(root, text, message):
    (root / f"data/fabric/{NAMES[1]}.csv").write_text(text)
    with pytest.raises(ValueError, match=f"{NAMES[1]}.csv: .*{message}") as failure:
        load_fabricslide16(root)
    assert "\n" not in str(failure.value)


def test_a_misnamed_file_and_an_empty_folder_are_named(root, tmp_path):
    (root / "data/fabric/notes.csv").write_text("x")
    with pytest.raises(ValueError, match=r"notes.csv: expected a name such as"):
        load_fabricslide16(root)
    with pytest.raises(ValueError, match="`vtbench fetch fabricslide16` brings them"):
        load_fabricslide16(tmp_path / "nowhere")


def test_an_incomplete_copy_is_refused(root, monkeypatch):
    (root.parent / "fabricslide16").symlink_to(root)
    monkeypatch.setenv("VTBENCH_DATA", str(root.parent))
    with pytest.raises(ValueError, match=r"964 of 966 recordings are missing.*vtbench fetch fabricslide16"):
        load_fabricslide16()


def test_the_published_recordings(real_recordings, tmp_path, monkeypatch):
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path))
    root = real_recordings("fabricslide16")
    recordings = load_fabricslide16(root)
    assert len(recordings) == 966
    names, counts = np.unique(recordings.fabric, return_counts=True)
    assert dict(zip(names.tolist(), counts.tolist(), strict=True)) == {
        "BeigeCotton": 180,
        "BrownCotton": 180,
        "Canvas": 180,
        "Denim": 72,
        "DenimFlex": 72,
        "Linen": 180,
        "WovenFabric": 102,
    }
    assert set(recordings.setting) == {120, 150, 180, 210, 250}
    lengths = [len(series) for series in recordings.series]
    assert (min(lengths), max(lengths)) == (141, 2117)
    period = np.median([np.median(np.diff(time)) for time in recordings.time_ms])
    assert period == PERIOD_MS
    check(recordings, root, [0, 400, 965])
    assert len(load_fabricslide16(root, "board")) == 24


def test_counts_do_not_depend_on_how_files_are_joined(root):
    paths = [f"data/fabric/{name}.csv" for name in NAMES]
    rows, counts = read_counts(root, paths, COLUMNS)
    assert list(rows) == [5, 6, 7]
    for path, part in zip(paths, np.split(counts, np.cumsum(rows)[:-1]), strict=True):
        np.testing.assert_array_equal(part, by_hand(root / path))
