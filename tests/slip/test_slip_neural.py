import subprocess
import sys

import numpy as np
import pytest
import torch
from slip_sequences import disagreement, stream
from slip_trials import contrast, stream_with_frames, trial, view

from slip.calibrate import cfar
from slip.detector import Detector
from slip.earlier_slip import prior
from slip.net import NetShape
from slip.net_camera import downsample
from slip.net_fit import noise_scale
from slip.net_pieces import Prepared, cut_pieces, labels
from slip.net_torch import TorchNet
from slip.neural import NeuralForce, NeuralForceFrames, load_detector
from slip.training_trial import TrainingTrial, latest_frame, samples_of_frames

TINY = {"channels": 4, "levels": 2, "hidden": 4}


def test_both_are_detectors_and_stream_as_they_batch(force_net, frames_net):
    unseen = trial(100)
    for detector in (force_net, frames_net):
        assert isinstance(detector, Detector)
        detector.reset()
        batch = detector.score(unseen.force)
        assert disagreement(stream(detector, unseen.force), batch, detector.window) <= 1e-12
    frames_net.reset()
    seen = frames_net.score(unseen.force, **view(unseen))
    assert disagreement(stream_with_frames(frames_net, unseen), seen, frames_net.window) <= 1e-12
    assert not np.allclose(seen, batch)


def test_long_sequences_are_scored_block_by_block_as_in_one_piece(force_net, monkeypatch):
    force = trial(101, samples=3000).force
    whole = force_net.score(force)
    monkeypatch.setattr("slip.net.ROWS_AT_A_TIME", 700)
    np.testing.assert_allclose(force_net.score(force), whole, rtol=1e-12)


def test_no_score_depends_on_what_comes_later(frames_net):
    one, other = trial(102), trial(103)
    at = 600
    force = np.concatenate([one.force[:at], other.force[at:]])
    frames = np.where((one.frame_samples < at)[:, None, None, None], one.frames, other.frames)
    changed = frames_net.score(force, frames=frames, frame_samples=one.frame_samples)
    same = frames_net.score(one.force, **view(one))
    np.testing.assert_allclose(changed[:at], same[:at], rtol=1e-12)
    assert not np.allclose(changed[at:], same[at:])


def test_a_spike_is_forgotten_after_the_window(force_net):
    force = trial(104).force
    spiked = force.copy()
    spiked[300] += 1e6
    gone = 300 + force_net.settling
    clean, score = force_net.score(force), force_net.score(spiked)
    np.testing.assert_allclose(score[gone:], clean[gone:], rtol=1e-12)
    assert not np.isclose(score[gone - 1], clean[gone - 1], rtol=1e-9)
    assert np.isfinite(score).all()


def test_slip_is_told_from_rest_by_the_sense_that_feels_it(force_net, frames_net):
    felt, only_seen = trial(105), trial(106, felt=False)
    assert contrast(force_net.score(felt.force), felt.state) > 0.95
    assert contrast(force_net.score(only_seen.force), only_seen.state) < 0.65
    assert contrast(frames_net.score(only_seen.force, **view(only_seen)), only_seen.state) > 0.85
    assert contrast(frames_net.score(felt.force), felt.state) > 0.9  # the camera is away


def test_the_weights_kept_are_those_that_fare_best_on_the_validation_trials(force_net):
    losses = [epoch.validation for epoch in force_net.history_]
    assert len(losses) == 6
    assert force_net.epoch_ == int(np.argmin(losses))
    assert losses[force_net.epoch_] < losses[0]


def test_validation_trials_choose_the_epoch_and_teach_nothing():
    trials = [trial(seed, samples=400) for seed in range(3)]
    against = [TrainingTrial(t.force, 2 - t.state) for t in trials]
    nets = [NeuralForce(**TINY).fit(trials, each, epochs=3, seed=2) for each in (trials, against)]
    assert [e.training for e in nets[0].history_] == [e.training for e in nets[1].history_]
    assert nets[0].epoch_ > nets[1].epoch_


def test_the_seed_gives_the_weights_and_leaves_torch_alone():
    torch.manual_seed(5)
    expected = torch.rand(3)
    torch.manual_seed(5)
    trials = [trial(seed, samples=400) for seed in range(3)]
    one, again, other = (NeuralForce(**TINY).fit(trials, epochs=2, seed=s).score(trials[0].force) for s in (3, 3, 4))
    np.testing.assert_array_equal(one, again)
    assert not np.allclose(one, other)
    torch.testing.assert_close(torch.rand(3), expected)


def test_trials_may_come_from_a_generator():
    trials = [trial(seed, samples=400) for seed in range(3)]
    listed, streamed = (NeuralForceFrames(**TINY, embedding=2, grid=4) for _ in range(2))
    listed.fit(trials, epochs=1)
    streamed.fit((each for each in trials), epochs=1)
    np.testing.assert_array_equal(listed.score(trials[0].force), streamed.score(trials[0].force))


def test_a_second_fit_owes_nothing_to_the_first():
    first, second = ([trial(10 * s + k, samples=400) for k in range(3)] for s in (1, 2))
    twice = NeuralForce(**TINY).fit(first, epochs=1).fit(second, epochs=1)
    once = NeuralForce(**TINY).fit(second, epochs=1)
    np.testing.assert_array_equal(twice.scale, once.scale)
    np.testing.assert_array_equal(twice.score(first[0].force), once.score(first[0].force))


@pytest.mark.parametrize(
    ("partial", "target", "weight"),
    [("ignore", [0, 0, 1], [1, 0, 1]), ("stick", [0, 0, 1], [1, 1, 1]), ("slip", [0, 1, 1], [1, 1, 1])],
)
def test_partial_slip_is_ignored_or_counted_as_asked(partial, target, weight):
    found = labels(np.array([0, 1, 2]), partial)
    np.testing.assert_array_equal(found, (target, weight))


def test_torch_and_numpy_are_the_same_net_piece_by_piece(frames_net):
    net = frames_net.net
    shape, unseen = net.shape, trial(107, samples=2300)
    differences = frames_net.with_scale(np.ones(4)).treated_differences(unseen.force)
    small = downsample(unseen.frames, shape.grid)
    change = np.diff(small, axis=0, prepend=small[:1])
    target, weight = labels(unseen.state, "ignore")
    prepared = Prepared(differences, unseen.state == 0, target, weight, change, unseen.frame_samples)
    pieces = cut_pieces([prepared], shape.reach, frames_net.scale, net.frame_scale)
    assert pieces.weight.sum() == weight.sum()
    module = TorchNet(shape)
    with torch.no_grad():
        for name, values in net.weights.items():
            layer, part = (name.removesuffix(".bias"), "bias") if name.endswith(".bias") else (name, "weight")
            getattr(module.linear[layer], part).copy_(torch.from_numpy(np.ascontiguousarray(values.T)))
        tensors = (torch.from_numpy(each) for each in (pieces.differences, pieces.change, pieces.latest))
        logits = module(*tensors, torch.ones(len(pieces.target))).numpy()
    told = np.logaddexp(0.0, logits)[pieces.weight > 0]
    np.testing.assert_allclose(told, frames_net.score(unseen.force, **view(unseen))[weight > 0], rtol=2e-3, atol=2e-4)
    for name, values in module.weights().items():
        np.testing.assert_array_equal(values, net.weights[name])


def test_the_window_is_how_far_the_net_looks_back():
    for levels in (1, 3, 5):
        assert NeuralForce(levels=levels).window == NetShape(taxels=1, levels=levels).reach == 2 ** (levels + 1) - 1


def test_noise_is_measured_where_nothing_happens():
    rng = np.random.default_rng(0)
    calm = np.array([1.0, 2.0, 0.0]) * rng.standard_normal((5000, 3))
    calm[2000:3000] *= 50.0
    np.testing.assert_allclose(noise_scale([calm]), [1.0, 2.0, noise_scale([calm])[2]], rtol=0.15)
    assert noise_scale([calm])[2] > 0.0


def test_what_is_saved_comes_back_to_the_bit(tmp_path, force_net, frames_net):
    unseen = trial(108)
    path = force_net.save(tmp_path / "force.npz")
    back = load_detector(path)
    assert type(back) is NeuralForce
    np.testing.assert_array_equal(back.score(unseen.force), force_net.score(unseen.force))
    back = load_detector(frames_net.save(tmp_path / "frames.npz"))
    assert type(back) is NeuralForceFrames
    np.testing.assert_array_equal(
        back.score(unseen.force, **view(unseen)), frames_net.score(unseen.force, **view(unseen))
    )
    with np.load(path, allow_pickle=False) as file:
        assert all(file[name].dtype != object for name in file.files)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["force.npz", "frames.npz"]


def test_files_that_hold_no_net_are_refused(tmp_path):
    text, other = tmp_path / "a.npz", tmp_path / "b.npz"
    text.write_text("nothing")
    np.savez(other, header="{}", scale=np.ones(3))
    for path in (text, other):
        with pytest.raises(ValueError, match="no trained slip net"):
            load_detector(path)
    with pytest.raises(FileNotFoundError):
        load_detector(tmp_path / "c.npz")


def test_torch_is_only_loaded_to_learn(tmp_path, force_net):
    path = force_net.save(tmp_path / "net.npz")
    code = f"import sys, slip; slip.load_detector({str(path)!r}).update([0.0] * 4); print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_a_threshold_is_found_as_for_any_detector(force_net):
    force = 0.5 + 1e-3 * np.random.default_rng(0).standard_normal((10_000, 4))
    found = cfar(force_net, force, 0.02)
    assert 0.005 < (found.detector.score(force)[found.detector.settling :] >= found.beta).mean() < 0.06
    earlier = trial(109)
    onset = int(np.argmax(earlier.state == 2))
    assert prior(force_net, earlier.force, (onset, len(earlier.force))).rest_rate < 0.05


def test_skipped_samples_still_bring_their_frames(frames_net):
    unseen = trial(110, samples=400)
    detector = frames_net.with_scale(frames_net.scale)
    detector.nan = "skip"
    broken = unseen.force.copy()
    gaps = unseen.frame_samples[[3, 7]]
    broken[gaps] = np.nan
    score = detector.score(broken, **view(unseen))
    detector.reset()
    streamed = stream_with_frames(detector, TrainingTrial(unseen.force, unseen.state, **view(unseen)))
    assert detector.skipped == 0
    detector.reset()
    frames = dict(zip(unseen.frame_samples.tolist(), unseen.frames, strict=True))
    skipping = np.array([detector.update(sample, frame=frames.get(t)) for t, sample in enumerate(broken)])
    np.testing.assert_allclose(skipping, score, rtol=1e-12)
    np.testing.assert_allclose(score[: gaps[0]], streamed[: gaps[0]], rtol=1e-12)
    assert score[gaps[0]] == score[gaps[0] - 1]


def test_a_net_that_has_learnt_nothing_scores_nothing():
    for net in (NeuralForce(), NeuralForceFrames()):
        with pytest.raises(ValueError, match="learnt nothing"):
            net.score(np.zeros((5, 4)))
        with pytest.raises(ValueError, match="learnt nothing"):
            net.update(np.zeros(4))
    with pytest.raises(ValueError, match="learnt nothing"):
        NeuralForceFrames().update(np.zeros(4), frame=np.zeros((20, 20, 3), dtype=np.uint8))


def test_a_net_keeps_to_the_taxels_it_has_learnt(force_net):
    with pytest.raises(ValueError, match="expected 4 taxels"):
        force_net.score(np.zeros((5, 3)))


@pytest.mark.parametrize(
    ("trials", "arguments", "says"),
    [
        ([], {}, "trials to learn from"),
        ([trial(0, 300)], {}, "trials to learn from"),
        ([trial(0, 300), trial(1, 300, taxels=3)], {}, "expected 4 taxels"),
        ([TrainingTrial(np.random.default_rng(0).normal(size=(300, 4)), np.zeros(300))] * 2, {}, "stick and of slip"),
        ([trial(0, 300)] * 2, {"device": "tpu"}, '"cpu" or "cuda"'),
        ([trial(0, 300)] * 2, {"partial": "maybe"}, "partial"),
        ([trial(0, 300)] * 2, {"epochs": 0}, "at least 1 epoch"),
    ],
)
def test_what_cannot_be_learnt_from_is_refused(trials, arguments, says):
    with pytest.raises(ValueError, match=says):
        NeuralForce(**TINY).fit(trials, **{"epochs": 1, **arguments})


def test_a_net_with_a_camera_needs_frames_to_learn_from():
    blind = TrainingTrial(trial(0, 300).force, trial(0, 300).state)
    with pytest.raises(ValueError, match="frames in every trial"):
        NeuralForceFrames(**TINY, embedding=2, grid=4).fit([blind, blind], epochs=1)


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device")
def test_a_device_that_is_not_there_is_said_before_any_work():
    with pytest.raises(ValueError, match="torch sees none"):
        NeuralForce(**TINY).fit([trial(0, 300)] * 2, device="cuda")


@pytest.mark.parametrize(
    "arguments",
    [
        {"state": np.zeros(9)},
        {"state": np.full(10, 3)},
        {"force": np.full((10, 4), np.nan)},
        {"frames": np.zeros((2, 8, 8, 3)), "frame_samples": [0, 1]},
        {"frames": np.zeros((2, 8, 8, 3), dtype=np.uint8)},
        {"frames": np.zeros((2, 8, 8, 3), dtype=np.uint8), "frame_samples": [4, 4]},
        {"frames": np.zeros((2, 8, 8, 3), dtype=np.uint8), "frame_samples": [0.0, 1.0]},
    ],
)
def test_trials_that_cannot_be_are_refused(arguments):
    with pytest.raises(ValueError, match="expected"):
        TrainingTrial(**{"force": np.zeros((10, 4)), "state": np.zeros(10), **arguments})


@pytest.mark.parametrize("size", [{"channels": 0}, {"levels": 13}, {"hidden": 0}])
def test_sizes_that_cannot_be_are_refused(size):
    with pytest.raises(ValueError, match="expected"):
        NeuralForce(**size)
    with pytest.raises(ValueError, match="whole patches"):
        NeuralForceFrames(grid=10)
    with pytest.raises(ValueError, match="embedding"):
        NeuralForceFrames(embedding=0)


def test_a_frame_belongs_to_the_first_sample_at_or_after_it():
    np.testing.assert_array_equal(samples_of_frames([0.0, 1 / 30, 0.1, 0.1005], 1000.0), [0, 34, 100, 101])
    np.testing.assert_array_equal(latest_frame(np.array([1, 3]), 5), [0, 1, 1, 2, 2])


@pytest.mark.parametrize("side", [(8, 8), (9, 13), (31, 17)])
def test_downsampling_keeps_each_cells_mean(side):
    frames = np.random.default_rng(0).integers(0, 256, (2, *side, 3), dtype=np.uint8)
    small = downsample(frames, 8)
    rows, columns = (np.arange(9) * n // 8 for n in side)
    for i, j in ((0, 0), (3, 6), (7, 7)):
        cell = frames[:, rows[i] : rows[i + 1], columns[j] : columns[j + 1]]
        np.testing.assert_allclose(small[:, i, j], cell.mean(axis=(1, 2)), rtol=1e-12)
    with pytest.raises(ValueError, match="at least 8 x 8"):
        downsample(frames[:, :5], 8)
