"""The fabric task on synthetic slides: what its features measure, and what its probes cannot know."""

from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest

from vtbench.run.evaluate import evaluate
from vtbench.run.features import DiskFeatures
from vtbench.run.methods import METHODS
from vtbench.run.work import works_of
from vtbench.tasks import TASKS
from vtbench.tasks.texture_fabricslide16 import HARMONICS_TRIED, N_HARMONICS, N_TAXELS, amplitudes, harmonics

TASK = TASKS.get("texture/fabricslide16/v1")
PERIODS = {"Canvas": 12, "Linen": 20, "Silk": 33}
FABRICS = tuple(PERIODS)
COUNT = count()


def stroke(periods, samples, phase=0.0, level=0.0, gain=1.0, noise=0.0, seed=0):
    """Counts (samples, 16): threads, `periods` of them in a stroke, each taxel a little behind the one before."""
    rng = np.random.default_rng(seed)
    x = np.arange(samples)[:, None] / samples
    wave = np.sin(2 * np.pi * periods * x + phase + 0.3 * np.arange(N_TAXELS))
    return level + gain * (wave + noise * rng.normal(size=wave.shape))


def spectrum(*series):
    return amplitudes(harmonics(list(series))).reshape(len(series), N_HARMONICS, N_TAXELS)


@pytest.mark.parametrize("periods", [1, 5, 20, 70])
def test_the_spectrum_peaks_at_the_number_of_threads_in_a_stroke(periods):
    got = spectrum(stroke(periods, 300))[0]
    assert (got.argmax(0) == periods - 1).all()
    np.testing.assert_allclose(got[periods - 1], np.sqrt(2), rtol=0.02)  # z-scored: amplitude of unit variance
    assert np.delete(got, periods - 1, 0).max() < 0.05


def test_speed_level_gain_and_phase_drop_out_of_the_spectrum():
    """The same fabric, faster, pressed harder, and starting on another thread."""
    alike = spectrum(
        stroke(20, 400),
        stroke(20, 150),
        stroke(20, 400, level=3000),
        stroke(20, 400, gain=50),
        stroke(20, 400, phase=1),
    )
    np.testing.assert_allclose(alike, np.broadcast_to(alike[0], alike.shape), atol=0.03)


def test_coefficients_know_where_a_thread_lies():
    one, two = harmonics([stroke(20, 400), stroke(20, 400, phase=np.pi)])
    np.testing.assert_allclose(one, -two, atol=1e-5)
    assert np.abs(one).max() > 1


def test_leading_columns_are_low_harmonics():
    """Every size that may be chosen keeps whole harmonics of all taxels."""
    series = [stroke(k, 400) for k in (HARMONICS_TRIED[0], HARMONICS_TRIED[0] + 1)]
    for name, features in (("spectrum", amplitudes(harmonics(series))), ("coefficients", harmonics(series))):
        (block,) = TASK.modalities[name].blocks
        assert features.shape[1] == block.leading[-1]
        energy = np.square(features[:, : block.leading[0]]).sum(1) / np.square(features).sum(1)
        assert energy[0] > 0.95
        assert energy[1] < 0.05


def slides(repetitions=6, noise=0.7, seed=0, fabrics=FABRICS):
    """Recordings of three fabrics at three grip settings, as the loader gives them."""
    rng = np.random.default_rng(seed)
    given = [(f, s, r) for f in fabrics for s in (120, 200, 250) for r in range(repetitions)]
    series = [
        stroke(
            PERIODS[fabric], int(rng.integers(145, 300)), rng.uniform(0, 6), rng.normal(500, 40), 9.0, noise, [seed, i]
        )
        for i, (fabric, _, _) in enumerate(given)
    ]
    names, setting, repetition = (np.array(values) for values in zip(*given, strict=True))

    class Slides(SimpleNamespace):
        def __len__(self):
            return len(self.series)

    return Slides(
        series=series,
        proximity=[rng.normal(100, 9, (len(s), 2)) for s in series],
        fabric=names,
        setting=setting,
        speed=np.full(len(series), 30),
        repetition=repetition,
        path=[f"data/fabric/{f}_{s}_{r}.csv" for f, s, r in given],
    )


@pytest.fixture
def load(tmp_path, monkeypatch):
    def from_slides(made):
        monkeypatch.setattr("vtbench.data.load_fabricslide16", lambda root: made, raising=False)
        return TASK.load(tmp_path, DiskFeatures(tmp_path), "none")

    return from_slides


def accuracy(data, feed, method="knn", split="held-out-setting"):
    identity = SimpleNamespace(
        split=split, variant="public", seed=0, dataset_hash="x", task=TASK.id, dataset="fabricslide16"
    )
    cell = SimpleNamespace(
        identity=identity,
        key=feed,
        task=TASK,
        feed=TASK.feed(feed),
        method=METHODS.get(method),
        timeout_s=600.0,
        group=("synthetic", str(next(COUNT)), feed),  # remembered reductions of other samples are not these
        backbone="none",
    )
    works, impossible = works_of([cell], data)
    assert not impossible
    got = evaluate(works[0]).predictions
    truth = dict(zip(data.ids.tolist(), data.labels.tolist(), strict=True))
    return np.mean(got["label"] == [truth[name] for name in got["sample_id"].tolist()])


@pytest.mark.parametrize("split", ["random", "held-out-setting"])
@pytest.mark.parametrize("method", ["ipca-wknn", "svm"])
def test_the_pipeline_tells_fabrics_apart_by_their_threads(load, method, split):
    assert accuracy(load(slides()), "spectrum", method, split) > 0.9


def test_probes_do_not_know_the_threads(load):
    """Levels and proximity are the same noise for all fabrics here; shuffled labels teach nothing."""
    data = load(slides(repetitions=12))
    for probe in TASK.probes:
        assert accuracy(data, probe) < 0.6, probe
    assert accuracy(data, "spectrum") > 0.9


def test_probes_find_a_session_that_gives_the_fabric_away(load):
    made = slides(noise=40.0)
    assert accuracy(load(made), "mean-levels") < 0.6
    shift = {"Canvas": 0, "Linen": 300, "Silk": 600}
    made.series = [s + shift[f] for s, f in zip(made.series, made.fabric, strict=True)]
    made.proximity = [p + shift[f] for p, f in zip(made.proximity, made.fabric, strict=True)]
    data = load(made)
    for probe in ("mean-levels", "proximity"):
        assert accuracy(data, probe) > 0.9
    assert accuracy(data, "spectrum") < 0.8  # threads are drowned in noise, and levels are none of its business


def test_blocks_see_their_own_channels_only(load):
    plain, moved = slides(repetitions=2), slides(repetitions=2)
    moved.proximity = [3 * p + 1 for p in moved.proximity]
    one = {name: load(plain).block(name) for name in ("spectrum", "coefficients", "mean-levels", "proximity")}
    two = {name: load(moved).block(name) for name in one}
    assert {name for name in one if not np.array_equal(one[name], two[name])} == {"proximity"}
    np.testing.assert_allclose(one["mean-levels"], [s.mean(0) for s in plain.series], rtol=1e-6)
    expected = [[*p.mean(0), *p.std(0)] for p in plain.proximity]
    np.testing.assert_allclose(one["proximity"], expected, rtol=1e-5)


def test_labels_and_conditions_follow_the_recordings(load):
    made = slides(repetitions=2, fabrics=FABRICS[::-1])
    data = load(made)
    assert data.classes == FABRICS
    assert [data.classes[i] for i in data.labels] == made.fabric.tolist()
    assert data.ids.tolist() == made.path
    assert data.factor("setting").tolist() == made.setting.tolist()
    split = TASK.variants["public"].splits["held-out-setting"](data, 0)
    assert [fold.name for fold in split.folds] == ["setting-120", "setting-200", "setting-250"]
    assert split.group_kind == "setting"
    random = TASK.variants["public"].splits["random"](data, 0)
    assert (len(random.folds), random.group_kind) == (10, "recording")
