"""Blocks of the tasks on presses: what each is computed from, and what it cannot know."""

from dataclasses import replace

import numpy as np
import pytest

from tests.vtbench.data import fakes
from vtbench.data import Dataset, write_dataset
from vtbench.run.features import DiskFeatures
from vtbench.tasks import TASKS, presses
from vtbench.tasks.base import NotPossibleError
from vtbench.tasks.presses import averaged, change, load_centroid

N = 26


class Mean:
    """A network that gives the mean colour, and counts the frames that it was shown."""

    weights_sha256 = "f00"

    def __init__(self):
        self.seen = 0

    def extract(self, images):
        self.seen += len(images)
        return images.reshape(len(images), -1, 3).mean(1).astype(np.float32)


@pytest.fixture
def network(monkeypatch):
    made = Mean()
    monkeypatch.setattr(presses, "_backbone", lambda name: made)
    return made


def write(folder, simulate=fakes.simulate, truth=()):
    return write_dataset(
        folder, fakes.FakeScene(), samples=N, seed=0, simulate=simulate, describe=fakes.describe, truth=truth
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write(tmp_path_factory.mktemp("presses") / "set", truth=("displacement",))


def load(task, folder, features):
    return TASKS.get(f"objects/{task}/v1").load(folder, DiskFeatures(features), "mean")


def test_the_centroid_is_the_mean_place_of_the_load():
    force = np.zeros((4, 16))
    force[0, 6] = 2.0  # row 1, column 2
    force[1, [0, 3]] = 1.0, 3.0  # along the first row
    force[2, [0, 12]] = 1.0, 1.0  # along the first column
    force[3, [5, 10]] = -7.0, 4.0  # a reading below zero is no load
    np.testing.assert_allclose(load_centroid(force), [[2, 1], [2.25, 0], [0, 1.5], [2, 2]])


def test_the_centroid_knows_nothing_of_the_total():
    force = np.random.default_rng(0).gamma(2.0, 1.0, (30, 16)).astype(np.float32)
    np.testing.assert_allclose(load_centroid(7 * force), load_centroid(force), rtol=1e-5)
    mirrored = force.reshape(-1, 4, 4)[:, :, ::-1].reshape(-1, 16)
    np.testing.assert_allclose(load_centroid(mirrored), load_centroid(force) * [-1, 1] + [3, 0], atol=1e-5)


def test_a_press_that_no_taxel_feels_has_its_centroid_in_the_middle():
    np.testing.assert_allclose(load_centroid(np.stack([np.zeros(16), -np.ones(16)])), [[1.5, 1.5]] * 2)
    np.testing.assert_allclose(load_centroid(np.zeros((1, 5))), [[2, 0]])  # taxels in a row


def test_change_is_the_difference_about_mid_grey_and_saturates():
    rest = np.array([[0, 100, 255, 0, 255, 37]], np.uint8)
    frames = np.array([[0, 110, 245, 255, 0, 36]], np.uint8)
    got = change(frames, rest)
    assert got.dtype == np.uint8
    assert got.tolist() == [[128, 138, 118, 255, 0, 127]]
    same = np.random.default_rng(0).integers(0, 256, (2, 8, 8, 3), dtype=np.uint8)
    assert np.unique(change(same, same)).tolist() == [128]


def test_averaging_keeps_the_mean_and_equals_cell_by_cell():
    grids = np.random.default_rng(0).normal(size=(3, 12, 8)).astype(np.float32)
    got = averaged(grids, 4)
    assert got.shape == (3, 4 * 4)
    by_hand = [[[g[3 * r : 3 * r + 3, 2 * c : 2 * c + 2].mean() for c in range(4)] for r in range(4)] for g in grids]
    np.testing.assert_allclose(got, np.reshape(by_hand, (3, 16)), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(got.mean(1), grids.mean((1, 2)), atol=1e-6)
    np.testing.assert_array_equal(averaged(grids, 64), grids.reshape(3, -1))  # never finer than it is
    assert averaged(np.ones((1, 13, 9), np.float32), 4).tolist() == [[1.0] * 16]  # what does not divide is cut


@pytest.mark.usefixtures("network")
def test_the_deep_task_has_no_shallow_press_and_interference_has_all(folder, tmp_path):
    table = Dataset.open(folder).columns(["id", "press", "label"])
    deep = table[table["press"] == "deep"]
    assert 0 < len(deep) < N
    for task, kept in (("deep", deep), ("pose", deep), ("interference", table)):
        data = load(task, folder, tmp_path)
        assert data.ids.tolist() == kept["id"].tolist()
        assert data.labels.tolist() == kept["label"].tolist()
        np.testing.assert_array_equal(data.block("force"), Dataset.open(folder).force(kept.index.to_numpy()))
        assert len(data.block("image")) == len(kept)


@pytest.mark.usefixtures("network")
def test_sessions_of_two_units_are_never_one(folder, tmp_path):
    data = load("interference", folder, tmp_path)
    pairs = set(zip(data.factor("unit").tolist(), data.factor("session").tolist(), strict=True))
    assert len(pairs) == len(set(data.factor("session").tolist()))


def test_blocks_are_what_their_names_say(folder, tmp_path, network):
    data, dataset = load("interference", folder, tmp_path), Dataset.open(folder)
    frames, rest = dataset.images(), dataset.images(column="image_rest")
    np.testing.assert_allclose(data.block("total-force")[:, 0], dataset.force().sum(1), rtol=1e-6)
    np.testing.assert_array_equal(data.block("load-centroid"), load_centroid(dataset.force()))
    np.testing.assert_array_equal(data.block("image"), network.extract(frames))
    np.testing.assert_array_equal(data.block("rest-frame"), network.extract(rest))
    np.testing.assert_array_equal(data.block("image-change"), network.extract(change(frames, rest)))
    truth = dataset.truth("displacement")
    np.testing.assert_allclose(data.block("true-displacement"), truth.reshape(N, -1), rtol=1e-6)


def other_frames(scene, index, seed, truth=()):
    made = fakes.simulate(scene, index, seed, truth)
    return replace(made, image=255 - made.image)


def other_forces(scene, index, seed, truth=()):
    made = fakes.simulate(scene, index, seed, truth)
    return replace(made, force=made.force[::-1].copy())


ALL = {"force", "load-centroid", "total-force", "image", "image-change", "rest-frame"}


@pytest.mark.parametrize(
    ("simulate", "moved"),
    [(other_frames, {"image", "image-change"}), (other_forces, {"force", "load-centroid"})],
)
@pytest.mark.usefixtures("network")
def test_a_probe_sees_only_what_it_should(folder, tmp_path, simulate, moved):
    """Frames of the press leave the rest frame alone; where the load is leaves the total alone."""
    one = load("interference", folder, tmp_path / "features")
    two = load("interference", write(tmp_path / "set", simulate), tmp_path / "features")
    assert {name for name in ALL if not np.allclose(one.block(name), two.block(name), rtol=1e-5)} == moved


@pytest.mark.usefixtures("network")
def test_without_ground_truth_there_is_no_upper_line(tmp_path):
    data = load("interference", write(tmp_path / "set"), tmp_path / "features")
    with pytest.raises(NotPossibleError, match="true-displacement"):
        data.block("true-displacement")
    with pytest.raises(NotPossibleError, match="finger"):
        data.factor("finger")


def test_frames_go_through_the_network_once(folder, tmp_path, network):
    load("interference", folder, tmp_path).block("image")
    assert network.seen == N
    again = load("deep", folder, tmp_path)  # the other task on the same presses
    assert len(again.block("image")) < N
    assert network.seen == N
    assert again.feature_us("image") > 0
    assert again.feature_us("rest-frame") is None
    assert again.feature_us("force") is None


def test_another_network_or_other_frames_are_not_taken_from_the_cache(folder, tmp_path, network):
    load("interference", folder, tmp_path).block("image")
    network.weights_sha256 = "f01"
    load("interference", folder, tmp_path).block("image")
    assert network.seen == 2 * N
    load("interference", write(tmp_path / "set", other_frames), tmp_path).block("image")
    assert network.seen == 3 * N
