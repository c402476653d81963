"""Each damage gives one line that names the shard, and the row and column where there is one."""

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.vtbench.data import fakes
from vtbench.data import Dataset, check_dataset, write_dataset
from vtbench.data.files import sha256_of
from vtbench.data.format import fixed_list
from vtbench.data.meta import content_hash, read_meta
from vtbench.data.png import encode_png

SHARD = "shard-00001.parquet"


@pytest.fixture
def folder(tmp_path):
    return write_dataset(
        tmp_path / "set",
        fakes.FakeScene(),
        samples=10,
        seed=1,
        truth=("pressure",),
        samples_per_shard=4,
        simulate=fakes.simulate,
        describe=fakes.describe,
    )


def alter(folder, column, change, *, kind=None):
    """Rewrite one column of the second shard and make `dataset.json` agree with the new file."""
    path = folder / SHARD
    table = pq.read_table(path, partitioning=None)
    place = table.column_names.index(column)
    values = change(table.column(place).to_pylist())
    if values is None:
        table = table.remove_column(place)
    else:
        kind = kind or table.schema.field(place).type
        table = table.set_column(place, pa.field(column, kind), pa.array(values, kind))
    pq.write_table(table, path, compression="zstd")
    meta = read_meta(folder)
    entry = meta.shards[1].model_copy(update={"bytes": path.stat().st_size, "sha256": sha256_of(path)})
    shards = (meta.shards[0], entry, *meta.shards[2:])
    meta = meta.model_copy(update={"shards": shards, "hash": content_hash(meta, shards)})
    (folder / "dataset.json").write_text(meta.model_dump_json())


def at(row, value):
    def change(values):
        values[row] = value
        return values

    return change


def nan_at(row, taxel):
    def change(values):
        values[row][taxel] = float("nan")
        return values

    return change


def test_a_sound_dataset_has_no_problems(folder):
    assert check_dataset(folder) == []


def test_a_truncated_shard_is_named(folder):
    path = folder / SHARD
    size = path.stat().st_size
    path.write_bytes(path.read_bytes()[:-100])
    expected = f"{SHARD}: truncated: {size - 100:,} bytes of {size:,}"
    assert check_dataset(folder) == [expected]
    with pytest.raises(ValueError, match=SHARD) as failure:
        Dataset.open(folder)
    assert expected in str(failure.value)


def test_a_checksum_that_is_off_is_named(folder):
    path = folder / SHARD
    data = bytearray(path.read_bytes())
    data[len(data) // 3] ^= 1
    path.write_bytes(data)
    assert any(f"{SHARD}: checksum is off" in problem for problem in check_dataset(folder))
    Dataset.open(folder, verify="size")
    with pytest.raises(ValueError, match=f"{SHARD}: checksum is off"):
        Dataset.open(folder, verify="sha256")


def test_missing_and_stray_shards_are_named(folder):
    (folder / SHARD).rename(folder / "shard-00099.parquet")
    missing, stray = check_dataset(folder)
    assert missing == f"{SHARD}: missing"
    assert stray.startswith("shard-00099.parquet: not one of the shards")


def test_an_edited_dataset_json_is_noticed(folder):
    path = folder / "dataset.json"
    data = json.loads(path.read_text())
    data["classes"] = data["classes"][::-1]
    path.write_text(json.dumps(data))
    assert any("its hash does not belong" in problem for problem in check_dataset(folder))
    with pytest.raises(ValueError, match="its hash does not belong"):
        Dataset.open(folder)


def test_not_a_parquet_file(folder):
    path = folder / SHARD
    path.write_bytes(bytes(path.stat().st_size))
    assert any(problem.startswith(f"{SHARD}: not readable as Parquet") for problem in check_dataset(folder))


ROW = f"{SHARD}, row 2 (id 'fake/1/00006'), column "


@pytest.mark.parametrize(
    ("column", "change", "expected"),
    [
        ("force", nan_at(2, 5), ROW + "'force': not finite at taxel 5"),
        ("taxel_load", nan_at(2, 15), ROW + "'taxel_load': not finite at taxel 15"),
        (
            "force_series",
            lambda series: at(2, [*series[2][:-1], [0.0, np.inf, *[0.0] * 14]])(series),
            ROW + "'force_series': not finite at taxel 1",
        ),
        ("total_force_n", at(2, float("nan")), ROW + "'total_force_n': not finite"),
        ("rate_hz", lambda v: v[:2] + [np.inf] * 2, ROW + "'rate_hz': not finite (and 1 more rows)"),
        ("object", at(2, None), ROW + "'object': no value"),
        ("press", at(2, "hard"), ROW + "'press': expected one of deep, shallow"),
        ("label", at(2, 4), ROW + "'label': outside 0..3"),
        ("label", at(2, 3), ROW + "'label': not the label of the row's object"),
        ("hold_stop", at(2, 10), ROW + "'hold_stop': the hold is empty or lies outside force_series"),
        ("hold_stop", at(2, 99), ROW + "'hold_stop': the hold is empty or lies outside force_series"),
        ("session", lambda values: None, f"{SHARD}: column 'session' is missing"),
        (
            "image",
            at(2, {"bytes": encode_png(np.zeros((20, 24, 3), np.uint8)), "path": "a.png"}),
            ROW + "'image': frame of 20x24 pixels, expected 24x24 (height x width)",
        ),
        ("image_rest", at(2, {"bytes": b"GIF89a", "path": "a.png"}), ROW + "'image_rest': not PNG data"),
        ("id", at(2, "fake/1/00001"), "id 'fake/1/00001' is given to 2 samples"),
    ],
)  # fmt: skip
def test_a_bad_cell_is_named(folder, column, change, expected):
    alter(folder, column, change)
    problems = check_dataset(folder)
    if column == "object":
        assert problems[0] == expected
    else:
        assert problems == [expected]


def test_fifteen_taxels_are_refused(folder):
    alter(folder, "force", lambda rows: [row[:15] for row in rows], kind=fixed_list(pa.float32(), 15))
    assert check_dataset(folder) == [f"{SHARD}, column 'force': 15 taxels, expected 16"]
    with pytest.raises(ValueError, match=f"{SHARD}, column 'force': 15 taxels, expected 16"):
        Dataset.open(folder).force()


def test_a_missing_column_is_refused_on_reading(folder):
    alter(folder, "session", lambda values: None)
    with pytest.raises(ValueError, match=f"{SHARD}: column 'session' is missing"):
        Dataset.open(folder).columns(["session"])


def test_nan_in_a_force_column_is_refused_on_reading(folder):
    alter(folder, "force", nan_at(2, 5))
    with pytest.raises(ValueError, match="sample 6, column 'force': not finite at taxel 5"):
        Dataset.open(folder).force()
    assert Dataset.open(folder).force([0, 1, 9]).shape == (3, 16)


def test_an_image_of_another_size_is_refused_on_reading(folder):
    small = {"bytes": encode_png(np.zeros((20, 24, 3), np.uint8)), "path": "a.png"}
    alter(folder, "image", at(2, small))
    with pytest.raises(ValueError, match=r"sample 6, column 'image': frame of shape \(20, 24, 3\)"):
        Dataset.open(folder).images()


def test_what_is_no_dataset_is_a_problem_too(tmp_path):
    (problem,) = check_dataset(tmp_path / "nowhere")
    assert "no dataset.json here" in problem
