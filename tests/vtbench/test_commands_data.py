"""Datasets through the command line: made, checked, damaged, imported, drawn."""

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.vtbench.data import fakes
from vtbench.data import write_dataset
from vtbench.data.files import sha256_of
from vtbench.data.meta import content_hash, read_meta
from vtbench.data.png import encode_png

SHARD = "shard-00001.parquet"
SCENE = """\
id: mine
title: two coins
objects: [coin-1-euro, coin-2-euro]
variations:
  loose: {pose: {jitter_mm: 2.0}}
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "my-scene.yaml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def dataset(tmp_path):
    return write_dataset(
        tmp_path / "set",
        fakes.FakeScene(),
        samples=6,
        samples_per_shard=4,
        simulate=fakes.simulate,
        describe=fakes.describe,
    )


def alter(folder, column, change, kind=None):
    """Change one column of a shard and let `dataset.json` agree with the new file."""
    path = folder / SHARD
    table = pq.read_table(path, partitioning=None)
    place = table.column_names.index(column)
    kind = kind or table.schema.field(place).type
    values = change(table.column(place).to_pylist())
    pq.write_table(table.set_column(place, pa.field(column, kind), pa.array(values, kind)), path)
    meta = read_meta(folder)
    entry = meta.shards[1].model_copy(update={"bytes": path.stat().st_size, "sha256": sha256_of(path)})
    shards = (meta.shards[0], entry)
    meta = meta.model_copy(update={"shards": shards, "hash": content_hash(meta, shards)})
    (folder / "dataset.json").write_text(meta.model_dump_json())


def truncated(folder):
    path = folder / SHARD
    path.write_bytes(path.read_bytes()[:-10])


def flipped(folder):
    data = bytearray((folder / SHARD).read_bytes())
    data[len(data) // 2] ^= 1
    (folder / SHARD).write_bytes(bytes(data))


def with_nan(folder):
    alter(folder, "force", lambda rows: [[float("nan"), *row[1:]] for row in rows])


def with_15_taxels(folder):
    alter(folder, "force", lambda rows: [row[:15] for row in rows], pa.list_(pa.float32(), 15))


def with_a_small_frame(folder):
    small = {"bytes": encode_png(np.zeros((5, 7, 3), np.uint8)), "path": "x.png"}
    alter(folder, "image", lambda rows: [small, *rows[1:]])


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (truncated, f"{SHARD}: truncated"),
        (flipped, f"{SHARD}: checksum is off"),
        (with_nan, "column 'force': not finite at taxel 0"),
        (with_15_taxels, "column 'force': 15 taxels, expected 16"),
        (with_a_small_frame, "column 'image': frame of 5x7 pixels, expected 24x24"),
        (lambda folder: (folder / SHARD).unlink(), f"{SHARD}: missing"),
        (lambda folder: (folder / "dataset.json").write_text("{"), "dataset.json"),
    ],
)
def test_damage_is_one_line_that_names_dataset_and_place(vtbench, refused, dataset, damage, message):
    assert vtbench("validate", dataset).out == f"{dataset}: ok (dataset, 6 samples)\n"
    damage(dataset)
    before = {path.name: path.read_bytes() for path in dataset.iterdir()}
    line = refused("validate", dataset)
    assert line.startswith(f"{dataset}")
    assert message in line
    answer = vtbench("validate", dataset, "--json")
    (found,) = json.loads(answer.out)
    assert (answer.code, found["ok"], found["kind"]) == (2, False, "dataset")
    assert message in found["problems"][0]
    assert {path.name: path.read_bytes() for path in dataset.iterdir()} == before


def test_one_bad_path_does_not_hide_the_verdict_on_the_others(vtbench, dataset, scene):
    answer = vtbench("validate", dataset, "nowhere", scene, "fvsight-press/hard")
    assert answer.code == 2
    assert [line.partition(": ")[0] for line in answer.out.splitlines()] == [
        str(dataset),
        str(scene),
        "fvsight-press/hard",
    ]
    assert answer.err.count("\n") == 1


def test_the_file_of_a_dataset_stands_for_its_folder(vtbench, dataset):
    assert vtbench("validate", dataset / "dataset.json").code == 0
    assert vtbench("validate", dataset / SHARD).code == 2


def test_configurations_are_told_apart_by_folder_or_keys(vtbench, scene, tmp_path):
    suites = tmp_path / "suites"
    suites.mkdir()
    suite = "id: mine\ntitle: t\nentries:\n  - {task: texture/fabricslide16/v1, variants: [public], methods: [svm]}\n"
    (suites / "a.yaml").write_text(suite)
    (tmp_path / "b.yaml").write_text(suite)
    answer = vtbench("validate", scene, suites / "a.yaml", tmp_path / "b.yaml", "--json")
    assert answer.code == 0, answer.err
    assert [found["kind"] for found in json.loads(answer.out)] == ["scene", "suite", "suite"]


def test_a_folder_of_configurations_is_checked_file_by_file(vtbench, scene):
    scene.with_name("broken.yaml").write_text("id: x\nid: y\n")
    answer = vtbench("validate", scene.parent)
    assert answer.code == 2
    assert str(scene) in answer.out
    assert "broken.yaml:2: key 'id' is given twice" in answer.err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("id: x\ntitle: t\npose: {reseat_m: 1}\n", ":3: pose.reseat_m: unknown key; did you mean 'reseat_mm'"),
        ("id: x\ntitle: t\nvariations:\n  a: {laod: {}}\n", ":4: laod: unknown key; did you mean 'load'?"),
        ("id: x\ntitle: [\n", ": not valid YAML"),
        ("", ": expected a mapping of keys to values, got an empty file"),
    ],
)
def test_a_bad_scene_file_is_named_with_line_and_key(refused, tmp_path, text, message):
    path = tmp_path / "x.yaml"
    path.write_text(text)
    line = refused("validate", path)
    assert line.startswith(str(path))
    assert message in line


def test_a_suite_is_checked_with_its_scenes(refused, tmp_path):
    path = tmp_path / "suite.yaml"
    path.write_text(
        "id: mine\ntitle: t\ndatasets:\n  - {id: paper, scene: fvsight-press, set: {pose.reseat_m: 1}}\n"
        "entries:\n  - {task: objects/deep/v1, variants: [paper], methods: [svm]}\n"
    )
    said = "dataset paper: set: pose.reseat_m: unknown key; did you mean 'reseat_mm' or 'reseat_deg'?"
    assert refused("validate", path) == f"{path}: {said}"
    assert refused("run", path, "-o", tmp_path / "out") == f"{path}: {said}"
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("pose.reseat_mm", "far", "set: pose.reseat_mm: expected a number, got 'far'"),
        ("pose..x", "1", "set: expected a key such as 'pose.shift_mm', got 'pose..x'"),
        ("pose", "3", "set: pose: expected a mapping of nominal_offset_mm, nominal_turn_deg, reseat_mm"),
        ("pose.jitter_mm.x", "3", "set: pose.jitter_mm: expected a number"),
        ("kind", "slide", "set: "),
    ],
)
def test_a_value_that_a_suite_sets_is_blamed_on_the_suite(refused, tmp_path, key, value, said):
    path = tmp_path / "suite.yaml"
    path.write_text(
        f"id: mine\ntitle: t\ndatasets:\n  - {{id: paper, scene: fvsight-press/hard, set: {{{key}: {value}}}}}\n"
        "entries:\n  - {task: objects/deep/v1, variants: [paper], methods: [svm]}\n"
    )
    line = refused("validate", path)
    assert line.startswith(f"{path}: dataset paper: {said}")
    assert "fvsight-press" not in line


def test_a_scene_that_is_wrong_by_itself_is_not_blamed_on_the_suite(refused, scene, tmp_path):
    scene.write_text(SCENE + "laod: {}\n")
    path = tmp_path / "suite.yaml"
    path.write_text(
        f"id: mine\ntitle: t\ndatasets:\n  - {{id: paper, scene: {scene}, set: {{pose.reseat_mm: 1}}}}\n"
        "entries:\n  - {task: objects/deep/v1, variants: [paper], methods: [svm]}\n"
    )
    assert f"dataset paper: {scene}:6: laod: unknown key; did you mean 'load'?" in refused("validate", path)


def test_a_folder_with_nothing_to_check_says_what_was_expected(refused, tmp_path):
    assert "expected a dataset (dataset.json), a run (suite.yaml) or YAML files" in refused("validate", tmp_path)


def test_generate_writes_what_it_says_and_does_it_once(vtbench, scene, tmp_path):
    out = tmp_path / "set"
    words = ("generate", scene, "-o", out, "--samples", "3", "--seed", "5", "--truth", "contact,pressure", "--json")
    first = json.loads(vtbench(*words).out)
    assert first["path"] == str(out)
    assert (first["name"], first["samples"], first["taxels"]) == ("mine", 3, 16)
    assert read_meta(out).truth.keys() == {"pressure", "contact"}
    stamps = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    assert json.loads(vtbench(*words).out)["hash"] == first["hash"]
    assert {path.name: path.stat().st_mtime_ns for path in out.iterdir()} == stamps
    assert vtbench("validate", out).code == 0


def test_a_refused_press_names_the_scenes_file_and_the_sample(refused, scene, tmp_path):
    scene.write_text(SCENE + "load: {deep_n: 41}\nsensor: {grid: 32}\n")
    line = refused("generate", scene, "--variation", "loose", "-o", tmp_path / "set")
    assert line.startswith(f"{scene}/loose: mine/loose, sample 0: a press of 4")
    assert "lower the load or raise tension_n_per_m" in line


def test_a_later_sample_that_is_refused_is_named_once(refused, scene, tmp_path):
    scene.write_text(SCENE + "load: {deep_n: 41, shallow_n: 1}\nprotocol: {shallow_rounds: [0]}\nsensor: {grid: 32}\n")
    line = refused("generate", scene, "-o", tmp_path / "set", "--samples", "4")
    assert line.startswith(f"{scene}: mine, sample 2: a press of 4")


def test_a_variation_is_part_of_the_scene_or_an_option(vtbench, scene, tmp_path):
    one = vtbench("generate", f"{scene}/loose", "-o", tmp_path / "a", "--samples", "1", "--json")
    two = vtbench("generate", scene, "--variation", "loose", "-o", tmp_path / "b", "--samples", "1", "--json")
    assert json.loads(one.out)["hash"] == json.loads(two.out)["hash"]
    assert json.loads(one.out)["name"] == "mine/loose"


def test_another_plan_does_not_overwrite_a_dataset(refused, vtbench, scene, tmp_path):
    assert vtbench("generate", scene, "-o", tmp_path / "a", "--samples", "1").code == 0
    assert "holds another dataset" in refused("generate", scene, "-o", tmp_path / "a", "--samples", "2")
    assert vtbench("validate", tmp_path / "a").code == 0


@pytest.mark.parametrize("command", ["generate", "run", "import"])
def test_a_folder_that_cannot_be_written_is_named(refused, tmp_path, scene, command):
    (tmp_path / "file").write_text("here")
    out = tmp_path / "file" / "set"
    folder = tmp_path / "recordings"
    write_recordings(folder)
    words = {"generate": [scene, "--samples", "1"], "run": ["texture-real"], "import": [folder]}[command]
    assert str(out) in refused(command, *words, "-o", out)
    assert (tmp_path / "file").read_text() == "here"


def test_a_misspelt_override_leaves_no_folder_behind(refused, scene, tmp_path):
    scene.write_text(SCENE + "laod: {}\n")
    refused("generate", scene, "-o", tmp_path / "set")
    assert not (tmp_path / "set").exists()


def write_recordings(folder):
    folder.mkdir()
    rng = np.random.default_rng(0)
    lines = ["file,object," + ",".join(f"f{i}" for i in range(1, 17))]
    for name, thing in (("a.png", "coin"), ("b.png", "key"), ("c.png", "coin")):
        (folder / name).write_bytes(encode_png(rng.integers(0, 256, (8, 9, 3), dtype=np.uint8)))
        lines.append(f"{name},{thing}," + ",".join(f"{force:.3f}" for force in rng.random(16)))
    (folder / "forces.csv").write_text("\n".join(lines) + "\n")


def test_import_makes_a_dataset_that_validates(vtbench, tmp_path):
    write_recordings(tmp_path / "recordings")
    answer = vtbench("import", tmp_path / "recordings", "-o", tmp_path / "set", "--name", "coins", "--json")
    found = json.loads(answer.out)
    assert (found["name"], found["samples"], found["objects"], found["image_size"]) == ("coins", 3, 2, [8, 9])
    assert vtbench("validate", tmp_path / "set").code == 0


def test_show_draws_a_dataset(vtbench, dataset, tmp_path):
    answer = vtbench("show", dataset, "-o", tmp_path / "sheet.png", "--json")
    assert json.loads(answer.out)["picture"] == str(tmp_path / "sheet.png")
    assert (tmp_path / "sheet.png").read_bytes().startswith(b"\x89PNG")


def test_missing_recordings_name_the_command_that_brings_them(refused, tmp_path, monkeypatch):
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("VTBENCH_DATA", raising=False)
    assert "`vtbench fetch fabricslide16`" in refused("show", "fabricslide16", "-o", tmp_path / "x.png")
