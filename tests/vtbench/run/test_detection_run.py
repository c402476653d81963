"""Slip suites from file to records, on cheap trials: baseline beside, thresholds from other trials, resume, rescore."""

import json

import numpy as np
import pytest

from leaderboard import slips
from leaderboard.record import read_predictions, read_records
from tests.vtbench.data.fake_slides import FakeSlipScene, simulate
from vtbench.data.slide_writer import write_slides
from vtbench.run import check_run, rescore, run_suite
from vtbench.run.detection.scoring import score_slips
from vtbench.run.detection.thresholds import fit, joined, rest_forces
from vtbench.run.suite import Suite
from vtbench.tasks import TASKS
from vtbench.tasks.slides import held_out_object, load_slides, random_folds


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    root = tmp_path_factory.mktemp("slides")
    slides = FakeSlipScene(n_samples=24, period=4)
    quiet = FakeSlipScene(id="fake-slip/negatives", n_samples=3, period=1, samples=6000)
    kept = {"simulate": simulate, "progress": False}
    return write_slides(root / "slides", slides, **kept), write_slides(root / "quiet", quiet, **kept)


@pytest.fixture
def suite(folders):
    def make(**entry):
        return Suite.model_validate(
            {
                "id": "slips",
                "title": "slips",
                "datasets": [{"id": name, "path": str(path)} for name, path in zip("ab", folders, strict=True)],
                "entries": [
                    {
                        "task": "slip/hard/v1",
                        "variants": {"hard": ["a", "b"]},
                        "modalities": ["prior"],
                        "methods": ["covariance"],
                        "probes": False,
                        **entry,
                    }
                ],
            }
        )

    return make


@pytest.fixture(scope="module")
def data(folders):
    return load_slides(folders)


def by_method(out):
    return {record.identity.method: record for record in read_records(out)}


def test_the_energy_baseline_is_always_there_and_no_better_than_itself(suite, tmp_path):
    run_suite(suite(), tmp_path / "out", progress=False)
    records = by_method(tmp_path / "out")
    assert set(records) == {"covariance", "energy"}
    assert check_run(tmp_path / "out") == []
    for record in records.values():
        assert record.status.state == "ok", record.status.reason
        assert record.metrics[0].name == "detected"
        assert record.identity.dataset == "a+b"
    for rate in (0.1, 1.0, 10.0):
        difference = slips.metric(records["energy"], "delay_minus_energy_ms", rate)
        assert (difference.low, difference.value, difference.high) == (0.0, 0.0, 0.0)
        beside = slips.metric(records["covariance"], "energy_delay_ms", rate)
        assert beside.value == slips.metric(records["energy"], "delay_ms", rate).value


def test_a_second_run_does_nothing_and_a_second_score_changes_nothing(suite, tmp_path):
    out = tmp_path / "out"
    run_suite(suite(), out, progress=False)
    before = {record.key: record for record in read_records(out)}
    assert run_suite(suite(), out, progress=False).done == 0
    assert rescore(out).done == 2
    assert {record.key: record for record in read_records(out)} == before


def test_predictions_do_not_depend_on_jobs(suite, tmp_path):
    for jobs in (1, 2):
        run_suite(suite(), tmp_path / str(jobs), jobs=jobs, progress=False)
    for record in read_records(tmp_path / "1"):
        one, two = (read_predictions(tmp_path / jobs, record.key) for jobs in "12")
        for name in one.keys() - {"cost_us"}:
            np.testing.assert_array_equal(one[name], two[name])


def test_unknown_detectors_and_datasets_are_named(suite):
    with pytest.raises(ValueError, match="unknown detector 'covarance'; did you mean 'covariance'"):
        suite(methods=["covarance"])
    with pytest.raises(ValueError, match=r"unknown dataset of slip/hard/v1, variant hard: 'c'"):
        suite(variants={"hard": ["a", "c"]})


@pytest.mark.parametrize("feed", ["prior", "cfar"])
def test_a_threshold_does_not_see_the_test_trials(data, feed, monkeypatch):
    fold = held_out_object(data, 0).folds[0]
    honest = fit("energy", feed, data, fold.train, 0.05)
    read = type(data).each_force

    def poisoned(self, trials):
        return ((t, force * (100.0 if t in fold.test else 1.0)) for t, force in read(self, trials))

    monkeypatch.setattr(type(data), "each_force", poisoned)
    assert fit("energy", feed, data, fold.train, 0.05).beta == honest.beta


def test_no_trial_is_in_both_parts_and_every_trial_is_tested_once(data):
    for rule in (held_out_object, random_folds(3)):
        split = rule(data, 0)
        tested = np.concatenate([fold.test for fold in split.folds])
        np.testing.assert_array_equal(np.sort(tested), np.arange(len(data)))
        for fold in split.folds:
            assert not set(fold.train) & set(fold.test)
    for fold in held_out_object(data, 0).folds:
        assert not set(data.factor("object")[fold.train]) & set(data.factor("object")[fold.test])


def test_rests_are_joined_without_a_jump(data):
    steps = joined([np.full((50, 2), level) for level in (1.0, 7.0, -3.0)])
    assert np.ptp(steps) == 0.0
    rest = rest_forces(data, np.arange(len(data)))
    first = next(data.each_force([0]))[1][:800]
    assert np.abs(np.diff(rest, axis=0)).max() < 2 * np.abs(np.diff(first, axis=0)).max()


def scored(data, trace, beta=1.0):
    """Metrics of a detector whose score is `trace(truth)`, thresholds 1."""
    from vtbench.run.detection.traces import Traces, trace_of

    task = TASKS.get("slip/hard/v1")
    kept = Traces.of([trace_of(trace(truth), truth, task.rule) for truth in data.truth])
    arrays = {
        "sample_id": data.ids,
        "group": data.ids,
        "fold": np.zeros(len(data), np.int32),
        "beta": np.array([beta]),
        "held": kept.values,
        "held_length": kept.lengths,
        "baseline_held": kept.values * 0 + np.float32(1),
        "baseline_held_length": kept.lengths,
        "cost_us": np.array([1.0, 2.0]),
    }
    return {metric.name: metric for metric in score_slips(arrays, data, task)}


def state_of(truth, delay=0):
    score = np.zeros(truth.samples)
    if truth.onset is not None:
        score[truth.onset + delay : truth.end] = 2.0
    return score


def test_a_detector_that_knows_the_state_is_late_by_the_hold_on_alone(data):
    metrics = scored(data, state_of)
    assert metrics["detected"].value == 1.0
    assert metrics["delay_ms"].value == pytest.approx(2.0)  # three periods in a row
    assert metrics["delay_ms@1"].value == pytest.approx(2.0)
    assert metrics["false_alarms_per_min"].value == 0.0
    assert metrics["false_alarms_per_min"].interval.startswith("Poisson")
    assert metrics["roc_area"].value == 1.0
    assert metrics["delay_minus_energy_ms@1"].high <= -slips.MISSED_MS  # the baseline here is always on: it misses all
    assert scored(data, lambda truth: state_of(truth, 40))["delay_ms"].value == pytest.approx(42.0)


def test_a_detector_that_never_alarms_misses_everything(data):
    metrics = scored(data, lambda truth: np.zeros(truth.samples))
    assert metrics["detected"].value == 0.0
    assert metrics["delay_ms"].value == slips.MISSED_MS
    assert metrics["roc_area"].value == 0.5


def test_only_the_ratio_of_score_to_threshold_counts(data):
    def noisy(truth, scale):
        rng = np.random.default_rng(truth.samples + (truth.onset or 0))
        return scale * (state_of(truth) + rng.gamma(1.0, 0.2, truth.samples))

    one = scored(data, lambda truth: noisy(truth, 1.0), beta=1.5)
    other = scored(data, lambda truth: noisy(truth, 64.0), beta=96.0)
    assert {name: (m.value, m.low, m.high) for name, m in one.items()} == {
        name: (m.value, m.low, m.high) for name, m in other.items()
    }


def test_a_rate_says_how_many_alarms_it_expects(data):
    metrics = scored(data, state_of)
    minutes = metrics["expected_alarms@1"].value
    assert metrics["expected_alarms@10"].value == pytest.approx(10 * minutes)
    assert minutes > 3 * 6.0 / 60  # the long trials of the second dataset count


def test_names_of_metrics_come_apart():
    assert slips.parse("delay_ms@0.1[speed=10 mm/s]") == slips.SlipName("delay_ms", 0.1, "speed", "10 mm/s")
    assert slips.parse("detected") == slips.SlipName("detected", None, "", "")
    assert slips.parse("not a name") is None


def test_choices_are_told(suite, tmp_path):
    run_suite(suite(), tmp_path / "out", progress=False)
    record = by_method(tmp_path / "out")["covariance"]
    notes = [json.loads(text) for text in read_predictions(tmp_path / "out", record.key)["choices"]]
    assert len(notes) == 3
    for note in notes:
        assert note["lowest"] <= note["beta"] <= note["highest"]


@pytest.mark.slow
def test_a_net_learns_from_the_training_trials_and_finds_the_slips(suite, tmp_path):
    run_suite(suite(methods=["neural-force"]), tmp_path / "out", progress=False)
    record = by_method(tmp_path / "out")["neural-force"]
    assert record.status.state == "ok", record.status.reason
    assert record.metrics[0].value > 0.9


def test_what_a_net_learns_from_are_the_states_of_the_trials(data):
    for trial, state in data.states([25, 3, 0]).items():
        truth = data.truth[trial]
        assert len(state) == truth.samples
        assert (state == 2).any() == (truth.onset is not None)
        if truth.onset is not None:
            assert int(np.flatnonzero(state == 2)[0]) == truth.onset
