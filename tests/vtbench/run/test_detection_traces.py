"""A kept trace says of every threshold what the whole score says."""

import numpy as np
import pytest

from slip.alarms import AlarmRule, Trial, quiet_peaks
from slip.delay import onset_delay
from slip.roc import trial_peak
from vtbench.run.detection.traces import Traces, kept_rule, trace_of, trial_of
from vtbench.tasks.slides import SlideTruth

RULE = AlarmRule(periods=3, early_s=0.25, settle_s=0.5)


def truth(samples=3000, onset=None, end=None, partial=None):
    return SlideTruth(
        kind="slide" if onset else "drift",
        object="ball",
        samples=samples,
        rate_hz=1000.0,
        onset=onset,
        end=end,
        partial=partial,
        rest=0,
        comparable=True,
        speed="10 mm/s",
        load="5 N",
        direction="0 deg",
    )


def a_score(seed, samples=3000):
    return np.random.default_rng(seed).gamma(2.0, 1.0, samples).astype(np.float32).astype(np.float64)


@pytest.mark.parametrize("samples", [400, 1000, 1700, 3000])
@pytest.mark.parametrize("seed", range(3))
def test_without_slip_alarms_are_counted_as_on_the_whole_score(seed, samples):
    what, score = truth(samples=samples), a_score(seed, samples)
    kept = trial_of(trace_of(score, what, RULE).astype(float), what, RULE)
    whole = Trial(score, 1000.0)
    for peaks, expected in zip(quiet_peaks(kept, kept_rule(RULE)), quiet_peaks(whole, RULE), strict=True):
        np.testing.assert_allclose(peaks, expected)
    assert trial_peak(kept, kept_rule(RULE)) == trial_peak(whole, RULE)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("partial", [None, 950])
def test_with_slip_delays_and_false_alarms_are_those_of_the_whole_score(seed, partial):
    what, score = truth(onset=1000, end=1800, partial=partial), a_score(seed)
    kept = trial_of(trace_of(score, what, RULE).astype(float), what, RULE)
    whole = Trial(score, 1000.0, 1000, 1800)
    for beta in (1.0, 3.0, 6.0, 20.0):
        assert onset_delay(kept, beta, kept_rule(RULE)) == onset_delay(whole, beta, RULE)
        peaks = [quiet_peaks(kept, kept_rule(RULE))[0], quiet_peaks(whole, RULE)[0]]
        assert (peaks[0] >= beta).sum() == (peaks[1] >= beta).sum()


def test_long_partial_slip_before_the_onset_is_neither_quiet_nor_slip():
    score = np.zeros(3000)
    score[600:1800] = 1.0  # on from the first partial slip to the end of the slip
    what = truth(onset=1000, end=1800, partial=600)
    kept = trial_of(trace_of(score, what, RULE).astype(float), what, RULE)
    assert onset_delay(kept, 0.5, kept_rule(RULE)) == pytest.approx(-0.25)
    assert not (quiet_peaks(kept, kept_rule(RULE))[0] >= 0.5).any()
    assert np.isinf(onset_delay(Trial(score, 1000.0, 1000, 1800), 0.5, RULE))  # on since before: a false alarm


@pytest.mark.parametrize("samples", [1001, 1400, 2100, 5499])
def test_a_short_rest_at_the_end_counts_with_the_piece_before(samples):
    what, score = truth(samples=samples), a_score(0, samples)
    kept = trial_of(trace_of(score, what, RULE).astype(float), what, RULE)
    peaks, minutes = quiet_peaks(kept, kept_rule(RULE))
    assert len(peaks) == samples // 1000
    assert minutes == pytest.approx(samples / 60_000)
    assert peaks.max() == trial_peak(Trial(score, 1000.0), RULE)


def test_traces_come_apart_as_they_were_put_together():
    parts = [np.arange(n, dtype=np.float32) for n in (3, 1, 5)]
    for part, again in zip(parts, Traces.of(parts).split(), strict=True):
        np.testing.assert_array_equal(part, again)
