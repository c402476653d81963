"""Datasets open in other people's tools, which know nothing of vtbench."""

import json
import os
import subprocess
import sys
import textwrap

import numpy as np
import pandas as pd
import pytest

from tests.vtbench.data import fake_slides, fakes
from vtbench.data import Dataset, check_dataset, write_dataset, write_slides
from vtbench.data.croissant import RECORDS

SAMPLES = 9


@pytest.fixture(scope="module")
def presses(tmp_path_factory):
    return write_dataset(
        tmp_path_factory.mktemp("presses") / "set",
        fakes.FakeScene(id="fake-press/hard"),
        samples=SAMPLES,
        seed=3,
        samples_per_shard=4,
        truth=("contact", "displacement"),
        simulate=fakes.simulate,
        describe=fakes.describe,
    )


@pytest.fixture(scope="module")
def slides(tmp_path_factory):
    return write_slides(
        tmp_path_factory.mktemp("slides") / "set",
        fake_slides.FakeSlipScene(),
        samples=3,
        samples_per_shard=2,
        frames=True,
        simulate=fake_slides.simulate,
    )


def elsewhere(code, **values):
    """What a fresh process without vtbench in reach prints last, as JSON."""
    text = "import json\n" + "".join(f"{name} = {str(value)!r}\n" for name, value in values.items())
    code = text + textwrap.dedent(code) + "\nassert 'vtbench' not in __import__('sys').modules"
    place = next(iter(values.values())).parent
    environment = {**os.environ, "HF_HUB_OFFLINE": "1", "HF_HOME": str(place / "hub")}
    done = subprocess.run([sys.executable, "-c", code], cwd=place, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_pandas_reads_the_shards(presses):
    frame = pd.read_parquet(sorted(presses.glob("shard-*.parquet")))
    dataset = Dataset.open(presses)
    assert len(frame) == SAMPLES
    np.testing.assert_array_equal(np.stack(frame["force"]), dataset.force())
    assert frame["image"][0]["bytes"].startswith(b"\x89PNG")


@pytest.mark.slow
def test_hugging_face_datasets_decodes_images_and_labels(presses):
    code = """
        import numpy as np
        from datasets import load_dataset
        rows = load_dataset("parquet", data_files=folder + "/shard-*.parquet", split="train",
                            cache_dir=folder + "-cache")
        row = rows[5]
        kinds = {name: type(feature).__name__ for name, feature in rows.features.items()}
        print(json.dumps([len(rows), kinds["image"], rows.features["label"].names, row["label"], row["force"],
                          np.asarray(row["image"]).tolist(), np.shape(row["force_series"])]))
    """
    n, kind, classes, label, force, image, series = elsewhere(code, folder=presses)
    dataset = Dataset.open(presses)
    assert (n, kind, classes, label) == (SAMPLES, "Image", list(fakes.OBJECTS), 1)
    np.testing.assert_array_equal(np.float32(force), dataset.force([5])[0])
    np.testing.assert_array_equal(image, dataset.images([5])[0])
    assert tuple(series) == dataset.force_series([5])[0].shape


@pytest.mark.slow
def test_the_official_validator_accepts_croissant_and_reads_records(presses, slides):
    code = """
        import mlcroissant
        import numpy as np
        presses, slides = (mlcroissant.Dataset(f"{folder}/croissant.json") for folder in (presses, slides))
        errors = [error for d in (presses, slides) for error in d.metadata.ctx.issues.errors]
        press = list(presses.records("recordings"))
        slide = list(slides.records("recordings"))
        row = {name.removeprefix("recordings/"): value for name, value in press[5].items()}
        print(json.dumps([sorted(errors), len(press), row["id"].decode(), np.asarray(row["image"]).tolist(),
                          np.array(row["force"]).tolist(), np.shape(row["truth_contact"]),
                          len(slide), np.asarray(slide[0]["recordings/frames"][0]).shape]))
    """
    errors, n, name, image, force, grid, trials, frame = elsewhere(code, presses=presses, slides=slides)
    dataset = Dataset.open(presses)
    assert (errors, n, name, trials) == ([], SAMPLES, dataset.columns(["id"])["id"][5], 3)
    np.testing.assert_array_equal(image, dataset.images([5])[0])
    np.testing.assert_array_equal(np.float32(force), dataset.force([5])[0])
    assert (grid, frame) == ([fakes.GRID, fakes.GRID], [8, 10, 3])


def test_croissant_lists_every_shard_and_column(presses):
    dataset = Dataset.open(presses)
    described = json.loads((presses / "croissant.json").read_text())
    listed = {part["name"]: part["sha256"] for part in described["distribution"] if "sha256" in part}
    assert listed == {shard.name: shard.sha256 for shard in dataset.meta.shards}
    (records,) = described["recordSet"]
    assert [field["@id"] for field in records["field"]] == [f"{RECORDS}/{name}" for name in dataset.meta.columns]


@pytest.mark.parametrize("damage", ["missing", "changed"])
def test_a_croissant_that_is_not_the_datasets_is_a_problem_until_written_again(tmp_path, damage):
    def write():
        scene = fakes.FakeScene()
        return write_dataset(tmp_path / "set", scene, samples=4, simulate=fakes.simulate, describe=fakes.describe)

    path = write() / "croissant.json"
    before, identity = path.read_bytes(), Dataset.open(path.parent).hash
    if damage == "missing":
        path.unlink()
    else:
        path.write_bytes(before.replace(b"16 taxels", b"17 taxels"))
    (problem,) = check_dataset(path.parent)
    assert problem.startswith("croissant.json: ")
    assert Dataset.open(path.parent).hash == identity
    write()
    assert path.read_bytes() == before
