"""The finger: grip kept, crown, texture at speed over pitch, friction, unit gains."""

import numpy as np
import pytest

from sensors.cpm_finger import FABRICS, CPMFinger, CPMFingerParameters, Fabric, share_load

STILL = {"grip_n": 5.0, "speed_mm_s": 0.0, "duration_s": 0.3}


def test_the_taxels_carry_the_regulated_grip_at_every_instant():
    slide = CPMFinger().slide(
        FABRICS["ribbed"], grip_n=4.0, speed_mm_s=80.0, duration_s=2.0, rng=np.random.default_rng(0)
    )
    assert slide.taxel_load.sum(axis=1) == pytest.approx(slide.grip_n, rel=1e-9)
    assert (slide.taxel_load >= 0).all()
    assert slide.grip_n.mean() == pytest.approx(4.0, rel=0.01)


def test_shared_load_is_the_springs_under_a_rigid_surface():
    rng = np.random.default_rng(1)
    height, total = rng.normal(0, 1, (200, 16)), 10 ** rng.uniform(-3, 2, 200)
    squeeze = share_load(height, total)
    assert squeeze.sum(axis=1) == pytest.approx(total, rel=1e-9)
    sunk = np.where(squeeze > 0, squeeze - height, -np.inf).max(axis=1)
    assert squeeze == pytest.approx(np.maximum(0, sunk[:, None] + height), abs=1e-9)
    assert (squeeze == 0).any()


def test_the_crown_carries_more_than_the_rim():
    held = CPMFinger().slide(FABRICS["fine"], **STILL).taxel_load[0].reshape(4, 4)
    assert held[1:3, 1:3].min() > held[[0, 0, 3, 3], [0, 3, 0, 3]].max()


def test_a_weave_beats_at_speed_over_pitch():
    stripes = Fabric(6.0, 1e6, 0.3, 0.0)
    slide = CPMFinger(CPMFingerParameters(grip_ripple=0.0)).slide(stripes, grip_n=6.0, speed_mm_s=30.0, duration_s=4.0)
    one = slide.taxel_load[:, 5] - slide.taxel_load[:, 5].mean()
    assert np.abs(np.fft.rfft(one)).argmax() / 4.0 == pytest.approx(30.0 / 6.0, abs=0.25)


def test_fine_weaves_are_averaged_away_by_the_taxels_area():
    coarse, fine = Fabric(9.0, 9.0, 0.3, 0.0), Fabric(0.5, 0.5, 0.3, 0.0)
    finger = CPMFinger(CPMFingerParameters(grip_ripple=0.0))
    move = {"grip_n": 5.0, "speed_mm_s": 20.0, "duration_s": 1.0}
    ripple = [finger.slide(fabric, **move).taxel_load.std(axis=0).mean() for fabric in (coarse, fine)]
    assert ripple[1] < 0.02 * ripple[0]


def test_drag_is_friction_along_the_slide():
    finger = CPMFinger()
    for speed in (60.0, -60.0):
        shear = finger.slide(FABRICS["coarse"], grip_n=5.0, speed_mm_s=speed, duration_s=1.0).shear[-1].sum(axis=0)
        assert shear == pytest.approx([np.sign(speed) * 0.55 * 5.0, 0], rel=0.01, abs=1e-12)
    assert (finger.slide(FABRICS["coarse"], **STILL).shear == 0).all()


def test_units_differ_and_a_unit_stays_itself():
    slides = [CPMFinger(unit=unit).slide(FABRICS["fine"], **STILL).force_series for unit in (0, 0, 1)]
    assert np.array_equal(slides[0], slides[1])
    assert not np.array_equal(slides[0], slides[2])


def test_the_clock_is_that_of_the_recordings():
    slide = CPMFinger().slide(FABRICS["fine"], grip_n=5.0, speed_mm_s=10.0, duration_s=1.4)
    assert slide.force_series.shape == (50, 16)
    assert np.diff(slide.force_time_s) == pytest.approx(0.028)


def test_slides_without_meaning_are_refused():
    for change in ({"grip_n": 0.0}, {"duration_s": 0.0}, {"speed_mm_s": np.nan}):
        with pytest.raises(ValueError, match="a slide needs"):
            CPMFinger().slide(FABRICS["fine"], **(STILL | change))
    with pytest.raises(ValueError, match="a fabric needs"):
        Fabric(0.0, 1.0, 0.1, 0.0)
