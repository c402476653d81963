"""Studies: what stands in for what, faults that do what they say, and splits that nothing crosses."""

from dataclasses import replace

import numpy as np
import pytest

from tests.vtbench.data import fakes
from tests.vtbench.run import small
from vtbench.config import load_suite
from vtbench.data import Dataset, write_dataset
from vtbench.onnx_eval.tested import on_datasets
from vtbench.run.features import DiskFeatures
from vtbench.run.methods import METHODS
from vtbench.tasks import TASKS, corruptions, presses
from vtbench.tasks.base import NotPossibleError, TaskData
from vtbench.tasks.corruptions import FORCE_FAULTS, FRAME_FAULTS, drawn_for, faulty_forces, faulty_frames
from vtbench.tasks.few_shot import PRESSES
from vtbench.tasks.granularity import felt
from vtbench.tasks.mispairing import another, clock_errors, force_at, late, nearest_distance, of_another_class
from vtbench.tasks.presses import change
from vtbench.tasks.study_splits import half_of, halves

STUDIES = ("pairing/v1", "robustness/v1", "granularity/v1", "few-shot/v1")
RNG = np.random.default_rng(0)
IDS = [f"press {i}" for i in range(12)]


class Mean:
    """A network that gives the mean colour."""

    weights_sha256 = "f00"

    def extract(self, images):
        return images.reshape(len(images), -1, 3).mean(1).astype(np.float32)


def simulate(scene, index, seed, truth=()):
    """Four objects in turn, twelve presses of each on each of two sensors."""
    made = small.simulate(scene, index, seed, truth)
    return replace(made, labels={**made.labels, "unit": index // 48})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = {"samples": 96, "seed": 0, "simulate": simulate, "describe": fakes.describe}
    return write_dataset(tmp_path_factory.mktemp("presses") / "set", fakes.FakeScene(), **made)


@pytest.fixture
def load(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(presses, "_backbone", lambda name: Mean())
    return lambda task: TASKS.get(task).load(folder, DiskFeatures(tmp_path), "mean")


def samples(objects=3, units=2, rounds=10):
    unit, _, label = (
        grid.ravel() for grid in np.meshgrid(np.arange(units), np.arange(rounds), np.arange(objects), indexing="ij")
    )
    n = len(label)
    ids = np.array([f"{i:06d}" for i in range(n)])
    names = tuple(f"object-{i}" for i in range(objects))
    return TaskData(ids, label.astype(np.int64), names, {"unit": unit}, np.arange(n), {})


def test_a_partner_is_another_of_the_pool_at_the_distance_asked_for():
    pool = np.repeat([0, 1], 10)
    places = RNG.uniform(-4, 4, (20, 2))
    for distance in (0.0, 3.0, 50.0):
        partner = nearest_distance(pool, places, distance)
        assert (partner != np.arange(20)).all()
        np.testing.assert_array_equal(pool[partner], pool)
        apart = np.linalg.norm(places - places[partner], axis=1)
        for at in range(20):
            others = [i for i in range(20) if pool[i] == pool[at] and i != at]
            miss = [abs(np.linalg.norm(places[at] - places[i]) - distance) for i in others]
            assert abs(apart[at] - distance) == pytest.approx(min(miss))


def test_random_partners_are_never_oneself_and_never_of_the_class_in_the_control():
    pool, labels = np.repeat([0, 1], 30), np.tile(np.arange(3), 20)
    same, other = another(pool, 0), of_another_class(pool, labels, 0)
    assert (same != np.arange(60)).all()
    np.testing.assert_array_equal(pool[same], pool)
    np.testing.assert_array_equal(pool[other], pool)
    assert (labels[other] != labels).all()
    assert len({*zip(labels.tolist(), labels[other].tolist(), strict=True)}) == 6  # no fixed exchange of classes
    with pytest.raises(NotPossibleError, match="one press only"):
        another(np.array([0, 0, 1]), 0)
    with pytest.raises(NotPossibleError, match="one object only"):
        of_another_class(np.array([0, 0]), np.array([1, 1]), 0)


def test_clocks_differ_within_what_is_said_whatever_the_order():
    one = clock_errors(IDS, 0.2)
    assert np.abs(one).max() <= 0.2
    assert len(set(one)) == len(IDS)
    np.testing.assert_array_equal(clock_errors(IDS[::-1], 0.2), one[::-1])
    np.testing.assert_allclose(clock_errors(IDS, 0.4), 2 * one)


def test_force_at_a_moment_is_the_force_of_that_moment():
    ramp = np.arange(1000)[:, None] * [1.0, 2.0]  # at 1000 Hz: newtons are milliseconds
    got = force_at([ramp, ramp, ramp], np.full(3, 1000.0), np.array([0.3, -1.0, 9.0]))
    np.testing.assert_allclose(got[0], [299.5, 599.0])
    np.testing.assert_allclose(got[1:, 0], [24.5, 974.5])  # before and after the recording: its ends


def test_a_history_of_a_wrong_clock_is_the_force_of_that_time_held_at_its_ends():
    ramp = np.arange(1000.0)[:, None] * [1.0, 2.0]  # at 1000 Hz: newtons are milliseconds
    right, behind, ahead = late([ramp] * 3, np.full(3, 1000.0), np.array([0.0, -0.2, 0.3]))
    np.testing.assert_array_equal(right, ramp)
    np.testing.assert_array_equal(behind[200:], ramp[:-200])
    np.testing.assert_array_equal(ahead[:-300], ramp[300:])
    assert (behind[:200] == ramp[0]).all()
    assert (ahead[-300:] == ramp[-1]).all()


def test_a_history_is_as_badly_paired_as_the_force(folder, load):
    """Where a variant takes the force of another press, it takes that press's history; clocks have the same error."""
    data, dataset = load("pairing/v1"), Dataset.open(folder)
    own, histories = dataset.force()[data.rows], data.block("force-series")
    assert len(np.unique(histories, axis=0)) == len(data)
    for other in ("place-4mm", "press", "class"):
        source = np.array([np.flatnonzero((own == row).all(1))[0] for row in data.block(f"force~{other}")])
        np.testing.assert_array_equal(data.block(f"force-series~{other}"), histories[source])
    table = dataset.columns(["id", "rate_hz"])
    shifted = late(dataset.force_series(), table["rate_hz"].to_numpy(), clock_errors(table["id"].tolist(), 0.2))
    got = data.block("force-series~time-200ms")
    np.testing.assert_array_equal(got, presses.in_steps(shifted, presses.STEPS)[data.rows])
    assert (got != histories).any(1).mean() > 0.9  # of short histories some are off by less than a sample


def test_every_feed_with_force_is_badly_paired():
    """A feed that a variant forgot would be scored on right pairs under a wrong pair's name."""
    task = TASKS.get("pairing/v1")
    for name, variant in task.variants.items():
        for block in {block.name for feed in task.modalities.values() for block in feed.blocks}:
            assert (block in variant.stand_ins) is (name != "paired" and block.startswith("force"))


def test_every_way_to_fuse_is_in_the_pairing_study():
    entries = [entry for entry in load_suite("studies").entries if entry.task == "pairing/v1"]
    fused = {name for entry in entries for name in entry.methods if any("fused" in feed for feed in entry.modalities)}
    usual = {name for name in METHODS if name != "ipca-wknn" and not name.endswith("-no-dropout")}
    assert fused == usual


def test_no_force_crosses_from_training_to_test(folder, load):
    """The rows of the dataset whose forces stand in a fold's training part are none of its test part's own rows."""
    data, task = load("pairing/v1"), TASKS.get("pairing/v1")
    own = Dataset.open(folder).force()[data.rows]
    for name, variant in task.variants.items():
        way = variant.stand_ins.get("force")
        if way is None or name.startswith("time-"):
            continue
        given = data.block(way.test)
        source = np.array([np.flatnonzero((own == row).all(1))[0] for row in given])
        assert (source != np.arange(len(data))).all()
        same_class = data.labels[source] == data.labels
        assert not same_class.any() if "class" in name else same_class.all()
        for rule in variant.splits.values():
            for fold in rule(data, 0).folds:
                assert not set(source[fold.train]) & set(fold.test)
                assert not set(source[fold.test]) & set(fold.train)


def test_halves_test_every_press_once():
    data = samples()
    split = halves(data, 0)
    assert sorted(np.concatenate([fold.test for fold in split.folds])) == list(range(len(data)))
    counts = np.bincount(data.labels * 2 + half_of(data))
    assert set(counts) == {10}  # as many of every object in each half
    assert len(set(split.interval_groups)) == len(data)


def test_few_presses_are_among_the_more_and_the_test_stays():
    data, task = samples(), TASKS.get("few-shot/v1")
    for name in ("random", "held-out-unit"):
        folds = {n: task.variants[f"presses-{n}"].splits[name](data, 0).folds for n in PRESSES}
        for n, of_n in folds.items():
            for fold, most in zip(of_n, folds[max(PRESSES)], strict=True):
                assert np.bincount(data.labels[fold.train]).tolist() == [n] * 3
                assert set(fold.train) <= set(most.train)
                np.testing.assert_array_equal(fold.test, most.test)
                units = {part: set(data.factors["unit"][rows]) for part, rows in vars(fold).items() if part != "name"}
                assert (units["train"] == units["test"]) is (name == "random")
    with pytest.raises(NotPossibleError, match="10 presses are needed"):
        task.variants["presses-1"].splits["random"](samples(rounds=9), 0)


@pytest.mark.parametrize("fault", FORCE_FAULTS)
def test_a_fault_of_the_array_does_not_depend_on_the_other_samples(fault):
    force = RNG.gamma(2.0, 1.0, (12, 16)).astype(np.float32)
    got = faulty_forces(fault, force, IDS)
    assert (got != force).any(1).all()
    np.testing.assert_array_equal(faulty_forces(fault, force[5:7], IDS[5:7]), got[5:7])
    if fault.startswith("dead-"):
        assert set((got != force).sum(1)) == {int(fault[5:])}
        assert (got[got != force] == 0).all()


@pytest.mark.parametrize("fault", FORCE_FAULTS)
def test_a_history_has_the_fault_of_its_press_at_every_step(fault):
    force = RNG.gamma(2.0, 1.0, (12, 16)).astype(np.float32)
    still = np.repeat(force[:, None], 5, axis=1)
    np.testing.assert_array_equal(
        faulty_forces(fault, still, IDS), np.repeat(faulty_forces(fault, force, IDS)[:, None], 5, axis=1)
    )


@pytest.mark.parametrize("fault", FRAME_FAULTS)
def test_a_fault_of_the_camera_leaves_the_rest_frame_and_the_other_samples_alone(fault):
    frames, rest = RNG.integers(0, 256, (2, 12, 24, 24, 3), dtype=np.uint8)
    before = rest.copy()
    got = faulty_frames(fault, frames, rest, IDS)
    assert got.dtype == np.uint8
    assert (got != frames).any((1, 2, 3)).all()
    np.testing.assert_array_equal(rest, before)
    np.testing.assert_array_equal(faulty_frames(fault, frames[3:5], rest[3:5], IDS[3:5]), got[3:5])


def test_faults_have_the_size_that_they_state():
    force = np.full((4000, 16), 2.0, np.float32)
    ids = [str(i) for i in range(4000)]
    assert faulty_forces("gain-20pct", force, ids).std() == pytest.approx(0.4, rel=0.02)
    assert faulty_forces("noise-0.5N", force, ids).std() == pytest.approx(0.5, rel=0.02)
    grey, rng = np.full((64, 64, 3), 128, np.uint8), drawn_for("a", "b")
    assert corruptions.frame_noise(10, grey, grey, rng).std() == pytest.approx(10, rel=0.05)
    np.testing.assert_array_equal(corruptions.blur(3, grey, grey, rng), grey)
    np.testing.assert_array_equal(corruptions.lighting(0, grey, grey, rng), grey)
    lit = corruptions.lighting(0.2, grey, grey, rng)
    assert len(np.unique(lit[..., 0])) == 1  # one factor a channel
    assert np.abs(lit / 128.0 - 1).max() <= 0.21
    assert (change(corruptions.frozen(lit, grey, rng), grey) == 128).all()


def test_features_of_a_faulty_camera_are_those_of_the_spoilt_frames(folder, load):
    data, dataset = load("robustness/v1"), Dataset.open(folder)
    frames, rest = dataset.images(data.rows), dataset.images(data.rows, column="image_rest")
    spoilt = faulty_frames("light-20pct", frames, rest, data.ids.tolist())
    np.testing.assert_array_equal(data.block("image-change~light-20pct"), Mean().extract(change(spoilt, rest)))
    assert not np.allclose(data.block("image-change~light-20pct"), data.block("image-change"))


def test_a_bit_of_touch_is_the_resolution_of_a_taxel(load):
    assert felt(np.array([[0.0, 0.19, 0.21, -3.0]], np.float32)).tolist() == [[0, 0, 1, 0]]
    data = load("granularity/v1")
    np.testing.assert_array_equal(data.block("contact")[:, 0], data.block("touched").max(1))
    with pytest.raises(NotPossibleError, match="pressure"):
        data.block("pressure")


def test_a_faulty_press_is_equally_faulty_for_a_net(load):
    """Pixels are of the spoilt frames, and the histories of dead taxels are zero where the averaged force is."""
    data = load("robustness/v1")
    np.testing.assert_array_equal(data.block("pixels-change~blur-2px"), data.block("image-change~blur-2px"))
    histories = data.block("force-series~dead-8").reshape(len(data), presses.STEPS, -1)
    dead = data.block("force~dead-8") == 0
    assert (dead.sum(1) >= 8).all()
    np.testing.assert_array_equal((histories == 0).all(1), dead)


def test_every_feed_of_the_robustness_study_meets_every_fault_of_its_modality():
    """A feed that a variant forgot would be scored on clean presses under the fault's name."""
    task = TASKS.get("robustness/v1")
    array = {*FORCE_FAULTS, "no-force"}
    for name, variant in task.variants.items():
        for feed in task.modalities.values():
            for block in feed.blocks:
                of_array = block.name.startswith("force")
                hit = name != "clean" and (name in array) is of_array
                assert (block.name in variant.stand_ins) is hit


@pytest.mark.parametrize("task", STUDIES)
def test_every_variant_reads_blocks_that_are_there(task, load):
    data = load(task)
    for variant in TASKS.get(task).variants.values():
        for name, way in variant.stand_ins.items():
            for other in (way.train, way.test):
                assert other in (None, "missing") or data.block(other).shape == data.block(name).shape


def test_a_model_cannot_be_tested_on_what_it_could_not_see(folder):
    with pytest.raises(ValueError, match="dead-2, changes features inside a run"):
        on_datasets("robustness/v1", "dead-2", None, [folder])
