import numpy as np
import pytest

from slip.alarms import AlarmRule, Trial, false_alarms_per_minute, held_score, quiet_peaks, threshold_at_rate
from slip.delay import delay_at_rate, onset_delay, paired_delay_interval
from slip.hold import hold_on
from slip.roc import area, roc_by_trial
from slip.scoring import trial_table

RATE_HZ = 100.0
RULE = AlarmRule(periods=3, refractory_s=1.0, settle_s=0.5)


def trial(seed, slip_level=None, delay=20, samples=1000, group="ball", kind=None):
    """Exponential noise; the score steps up `delay` samples after an onset at 400."""
    score = np.random.default_rng(seed).exponential(size=samples)
    if slip_level is None:
        return Trial(score, RATE_HZ, kind=kind or "quiet", group=group)
    score[400 + delay : 700] += slip_level
    return Trial(score, RATE_HZ, 400, 700, kind=kind or "slip", group=group)


def many(slip_level=30.0, delay=20, negatives=200):
    slips = [trial(seed, slip_level, delay) for seed in range(20)]
    return slips + [trial(1000 + seed) for seed in range(negatives)]


def test_held_score_is_the_largest_beta_that_holds_on():
    scored = trial(0)
    held = held_score(scored, RULE)
    for beta in (0.5, 1.0, 2.0):
        np.testing.assert_array_equal((held >= beta), hold_on(scored.score >= beta, RULE.periods))


@pytest.mark.parametrize("per_minute", [0.5, 1.0, 10.0])
def test_threshold_gives_at_most_the_asked_rate_and_the_next_lower_more(per_minute):
    trials = many()
    pairs = [quiet_peaks(each, RULE) for each in trials]
    peaks, minutes = [p for p, _ in pairs], sum(m for _, m in pairs)
    beta, supported = threshold_at_rate(peaks, minutes, per_minute)
    every = np.concatenate(peaks)
    assert (every >= beta).sum() <= per_minute * minutes
    assert (every >= np.nextafter(beta, -np.inf)).sum() > per_minute * minutes - 1
    assert supported == (per_minute * minutes >= 30)


def test_a_rate_of_a_tenth_needs_three_hundred_minutes():
    peaks = [np.arange(20_000.0)]
    assert not threshold_at_rate(peaks, 299.0, 0.1)[1]
    assert threshold_at_rate(peaks, 300.0, 0.1)[1]


def test_one_long_alarm_counts_once_per_refractory_time():
    score = np.zeros(1000)
    score[200:300] = 5.0
    peaks, minutes = quiet_peaks(Trial(score, RATE_HZ), AlarmRule(periods=1, refractory_s=1.0))
    assert (peaks >= 1.0).sum() == 1
    assert minutes == pytest.approx(1000 / RATE_HZ / 60)


def test_time_in_slip_and_while_settling_counts_neither_way():
    loud = trial(0, slip_level=100.0)
    peaks, minutes = quiet_peaks(loud, RULE)
    assert peaks.max() < 50.0
    assert minutes == pytest.approx((400 + 250) / RATE_HZ / 60)


@pytest.mark.parametrize("delay", [0, 7, 50])
def test_delay_of_a_step_is_its_lag_and_the_hold(delay):
    measured = onset_delay(trial(1, 30.0, delay), 20.0, RULE)
    assert measured == pytest.approx((delay + RULE.periods - 1) / RATE_HZ)


def test_a_miss_is_infinite_and_never_averaged():
    assert onset_delay(trial(1, 30.0), 1e3, RULE) == np.inf
    half = [trial(s, 30.0) for s in range(2)] + [trial(s, 0.0) for s in range(2, 4)]
    result = delay_at_rate(half + [trial(90 + s) for s in range(30)], 1.0, RULE, draws=50)
    assert result.detected == 0.5
    assert result.median_s == np.inf


def test_an_alarm_that_was_on_before_the_onset_detects_nothing():
    score = np.zeros(1000)
    score[350:600] = 10.0
    before = Trial(score, RATE_HZ, 400, 700)
    assert onset_delay(before, 5.0, RULE) == np.inf
    allowed = AlarmRule(periods=3, early_s=0.6)
    assert onset_delay(before, 5.0, allowed) == pytest.approx((350 + 2 - 400) / RATE_HZ)


def test_a_stricter_rate_is_never_faster():
    trials = many(slip_level=4.0)
    delays = [delay_at_rate(trials, rate, RULE, draws=20).median_s for rate in (0.5, 1.0, 10.0)]
    assert delays == sorted(delays, reverse=True)


def test_intervals_hold_the_estimate_and_pairing_finds_a_slower_detector():
    fast = delay_at_rate(many(delay=20), 1.0, RULE, draws=200)
    slow = delay_at_rate(many(delay=45), 1.0, RULE, draws=200)
    for result in (fast, slow):
        assert result.median_interval_s[0] <= result.median_s <= result.median_interval_s[1]
        assert result.detected_interval == (1.0, 1.0)
    low, high = paired_delay_interval(fast, slow)
    assert high < 0.0
    assert low == pytest.approx(-0.25, abs=0.02)
    assert paired_delay_interval(fast, fast) == (0.0, 0.0)


def test_roc_of_a_perfect_and_of_a_blind_detector():
    perfect = roc_by_trial(many(slip_level=50.0), RULE, draws=50)
    assert perfect.area == 1.0
    slips = np.random.default_rng(0).standard_normal(2000)
    assert area(slips, np.random.default_rng(1).standard_normal(2000)) == pytest.approx(0.5, abs=0.03)
    assert area(np.zeros(5), np.zeros(7)) == 0.5


def test_roc_rises_from_corner_to_corner_and_its_area_is_the_pair_count():
    found = roc_by_trial(many(slip_level=1.0, negatives=40), RULE, draws=50)
    for rates in (found.false_positive, found.true_positive):
        assert (np.diff(rates) >= 0.0).all()
        assert (rates[0], rates[-1]) == (0.0, 1.0)
    assert np.trapezoid(found.true_positive, found.false_positive) == pytest.approx(found.area)
    assert found.area_interval[0] <= found.area <= found.area_interval[1]


def test_any_rising_change_of_score_leaves_roc_and_delays_alone():
    trials = many(slip_level=3.0, negatives=60)
    bent = [Trial(np.exp(t.score / 9.0), t.rate_hz, t.onset, t.end, t.kind, t.group) for t in trials]
    assert roc_by_trial(bent, RULE, draws=10).area == roc_by_trial(trials, RULE, draws=10).area
    plain, curved = (delay_at_rate(each, 2.0, RULE, draws=10) for each in (trials, bent))
    np.testing.assert_array_equal(plain.delays_s, curved.delays_s)


def test_table_counts_by_object_in_order():
    trials = [trial(s, 30.0, group="ball") for s in range(3)]
    trials += [trial(9, 0.0, group="cylinder"), trial(10, 30.0, group="cylinder"), trial(11, group="cylinder")]
    rows = trial_table(trials, 15.0, RULE)
    assert [(r.group, r.slips, r.slips_called) for r in rows] == [("ball", 3, 3), ("cylinder", 2, 1)]
    assert [(r.quiet_trials, r.quiet_called) for r in rows] == [(3, 0), (3, 0)]
    assert rows[1].accuracy == 0.5


def test_false_alarms_are_told_apart_by_kind():
    calm, shaken = trial(0, kind="drift"), Trial(np.full(1000, 9.0), RATE_HZ, kind="tapping")
    rates = false_alarms_per_minute([calm, shaken], 8.5, RULE)
    assert rates["drift"] == 0.0
    assert rates["tapping"] == pytest.approx(60.0)


@pytest.mark.parametrize(
    "arguments",
    [
        {"score": [1.0, np.nan]},
        {"score": [[1.0]]},
        {"onset": 3},
        {"onset": 5, "end": 5},
        {"onset": 0, "end": 11},
        {"rate_hz": 0.0},
    ],
)
def test_trials_that_cannot_be_are_refused(arguments):
    with pytest.raises(ValueError, match="expected"):
        Trial(**{"score": np.zeros(10), "rate_hz": RATE_HZ, **arguments})


def test_scores_need_both_kinds_of_trial():
    with pytest.raises(ValueError, match="with and without"):
        roc_by_trial([trial(0)], RULE)
    with pytest.raises(ValueError, match="at least one slip"):
        delay_at_rate([trial(0)], 1.0, RULE)
    with pytest.raises(ValueError, match="without an onset"):
        onset_delay(trial(0), 1.0, RULE)
    with pytest.raises(ValueError, match="time without slip"):
        threshold_at_rate([], 0.0, 1.0)
