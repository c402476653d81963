"""One battery over every named detector."""

import inspect
import pickle

import numpy as np
import pytest
from slip_sequences import disagreement, eventful, rest, stream

import slip
from slip.detector import Detector

NAMES = slip.detector_names()


@pytest.fixture(params=NAMES)
def name(request):
    return request.param


def test_every_name_is_a_detector_with_a_docstring(name):
    detector = slip.make_detector(name)
    assert isinstance(detector, Detector)
    assert inspect.getdoc(type(detector))


@pytest.mark.parametrize("window", [2, 50])
def test_stream_and_batch_agree_also_after_a_spike(name, window):
    force = eventful(1500, spike_at=400)
    detector = slip.make_detector(name, window=window)
    batch = detector.score(force)
    assert batch.shape == (1500,)
    assert batch.dtype == np.float64
    assert disagreement(stream(detector, force), batch, window) <= 1e-12


@pytest.mark.parametrize("samples", [0, 1, 2])
def test_the_shortest_sequences_have_scores(name, samples):
    force = rest(samples)
    detector = slip.make_detector(name)
    assert detector.score(force).shape == (samples,)
    np.testing.assert_array_equal(stream(detector, force), detector.score(force))
    assert (detector.score(force)[:1] == 0.0).all()


def test_forces_that_stand_still_score_zero_exactly(name):
    force = np.tile(np.linspace(0.0, 50.0, 16), (300, 1))
    detector = slip.make_detector(name)
    assert (detector.score(force) == 0.0).all()
    assert (stream(detector, force) == 0.0).all()


def test_score_settles_to_what_came_since(name):
    detector = slip.make_detector(name, window=20)
    spiked, clean = eventful(600, spike_at=200), eventful(600)
    gone = slice(200 + detector.settling, None)
    expected = detector.score(clean)[gone]
    np.testing.assert_allclose(detector.score(spiked)[gone], expected, rtol=1e-9, atol=1e-12 * expected.max())


def test_slip_scores_above_rest(name):
    score = slip.make_detector(name).score(eventful(3000))
    assert np.median(score[2100:]) > 10.0 * score[100:1000].max()


def test_reset_forgets_and_batch_leaves_the_stream_alone(name):
    force = eventful(300)
    detector = slip.make_detector(name, window=10)
    first = stream(detector, force)
    detector.reset()
    half = stream(detector, force[:150])
    detector.score(eventful(200, seed=9))
    np.testing.assert_array_equal(np.concatenate([half, stream(detector, force[150:])]), first)


def test_a_pickled_stream_goes_on_where_it_was(name):
    force = eventful(200)
    detector = slip.make_detector(name, window=10)
    stream(detector, force[:100])
    copy = pickle.loads(pickle.dumps(detector))
    np.testing.assert_array_equal(stream(copy, force[100:]), stream(detector, force[100:]))


def test_a_copy_with_another_scale_shares_no_state(name):
    force = eventful(200)
    detector = slip.make_detector(name, window=10)
    stream(detector, force[:100])
    whitened = detector.with_scale(np.full(16, 2.0))
    np.testing.assert_array_equal(stream(whitened, force[:50]), stream(detector.with_scale([2.0] * 16), force[:50]))
    same = detector.with_scale(np.ones(16))
    np.testing.assert_array_equal(same.score(force), detector.score(force))


def test_missing_samples_are_refused_by_default(name):
    force = eventful(50)
    force[7, 3] = np.nan
    with pytest.raises(ValueError, match=r"1 of 50 samples, first at sample 7"):
        slip.make_detector(name).score(force)
    detector = slip.make_detector(name)
    detector.update(force[0])
    with pytest.raises(ValueError, match="NaN"):
        detector.update(force[7])


def test_missing_samples_can_be_skipped_and_are_counted(name):
    force = eventful(300)
    gaps = [0, 1, 40, 41, 200, 299]
    broken = force.copy()
    broken[gaps, 5] = np.nan
    present = np.setdiff1d(np.arange(300), gaps)
    detector = slip.make_detector(name, window=10, nan="skip")
    score = detector.score(broken)
    assert detector.skipped == len(gaps)
    np.testing.assert_array_equal(score[present], detector.score(force[present]))
    assert (score[[0, 1]] == 0.0).all()
    assert score[40] == score[41] == score[39]
    detector.reset()
    assert disagreement(stream(detector, broken), score, 10) <= 1e-12
    assert detector.skipped == len(gaps)


@pytest.mark.parametrize("nan", ["refuse", "skip"])
@pytest.mark.parametrize("bad", [np.inf, -np.inf, 1e200])
def test_infinite_and_absurd_readings_are_always_refused(name, nan, bad):
    force = eventful(20)
    force[4, 4] = bad
    detector = slip.make_detector(name, nan=nan)
    with pytest.raises(ValueError, match="infinite or larger"):
        detector.score(force)
    with pytest.raises(ValueError, match="infinite or larger"):
        stream(detector, force)


def test_irregular_sampling_is_refused_where_times_are_given(name):
    force, times = eventful(30), np.arange(30) / 1000.0
    detector = slip.make_detector(name, window=5)
    np.testing.assert_array_equal(detector.score(force, time_s=times), detector.score(force))
    late = times + 0.0005 * (np.arange(30) >= 12)
    with pytest.raises(ValueError, match="before sample 12"):
        detector.score(force, time_s=late)
    for sample, time in zip(force[:12], late, strict=False):
        detector.update(sample, time_s=time)
    with pytest.raises(ValueError, match="regular sampling"):
        detector.update(force[12], time_s=late[12])
    with pytest.raises(ValueError, match="timestamps"):
        detector.score(force, time_s=times[:-1])


@pytest.mark.parametrize("shape", [(10,), (10, 0), (2, 5, 16)])
def test_wrong_shapes_are_refused(name, shape):
    with pytest.raises(ValueError, match="shape"):
        slip.make_detector(name).score(np.zeros(shape))


def test_a_stream_keeps_to_its_number_of_taxels(name):
    detector = slip.make_detector(name)
    detector.update(np.zeros(16))
    with pytest.raises(ValueError, match=r"\(16,\)"):
        detector.update(np.zeros(15))


@pytest.mark.parametrize("window", [0, 1, -3, 2.5, True])
def test_a_window_needs_two_whole_samples(name, window):
    with pytest.raises(ValueError, match="window"):
        slip.make_detector(name, window=window)


@pytest.mark.parametrize(
    "parameters", [{"common_mode": "median"}, {"nan": "zero"}, {"scale": [0.0, 1.0]}, {"scale": [[1.0]]}]
)
def test_parameters_out_of_range_are_refused(parameters):
    with pytest.raises(ValueError, match="expected"):
        slip.make_detector("energy", **parameters)


def test_a_misspelt_name_gets_the_close_one():
    with pytest.raises(ValueError, match="did you mean 'covariance'"):
        slip.make_detector("covarianc")


def test_every_lazy_export_is_there():
    for export in slip.__all__:
        assert callable(getattr(slip, export)), export
    with pytest.raises(AttributeError):
        _ = slip.nothing
