"""Training presses: the same bytes from the same seed, kept by unit, nothing shared with validation or with tasks."""

import numpy as np
import pytest

from sensors.fvsight import FVSightParameters, FVSightUnit
from sensors.press import gap_under
from vtbench.training import presses
from vtbench.training.presses import TrainingPlan, ValidationPlan, data_sha256, pooled, training_presses

SMALL = TrainingPlan(seed=3, presses=5, shapes=6, per_unit=2)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("presses")
    return folder, training_presses(SMALL, folder)


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(made, tmp_path):
    _, first = made
    assert {name: (values.shape, values.dtype.name) for name, values in first.items()} == {
        "frame": ((5, 3, 64, 64), "uint16"),
        "change": ((5, 3, 64, 64), "uint16"),
        "pressure": ((5, 32, 32), "float16"),
        "displacement": ((5, 32, 32), "float16"),
        "shape": ((5,), "int64"),
    }
    assert data_sha256(training_presses(SMALL, tmp_path)) == data_sha256(first)
    other = training_presses(TrainingPlan(seed=4, presses=1, shapes=6, per_unit=1), tmp_path)
    assert not np.array_equal(other["frame"][0], first["frame"][0])


def test_what_is_kept_is_not_simulated_again_and_what_is_missing_is(made, monkeypatch):
    folder, first = made
    (at,) = folder.glob("training-*")
    kept = at / "unit-0001.npz"
    whole = kept.read_bytes()
    kept.unlink()
    pressed = []
    press = presses.press_shape
    monkeypatch.setattr(presses, "press_shape", lambda *a: pressed.append(a[1]) or press(*a))
    assert data_sha256(training_presses(SMALL, folder)) == data_sha256(first)
    assert pressed == first["shape"][2:4].tolist()
    assert kept.read_bytes() == whole


def test_a_longer_plan_begins_with_the_shorter_one(made):
    folder, first = made
    longer = training_presses(TrainingPlan(seed=3, presses=6, shapes=6, per_unit=2), folder)
    np.testing.assert_array_equal(longer["change"][:5], first["change"])
    assert sorted(longer["shape"]) == list(range(6))


def test_frame_and_change_tell_of_the_press(made):
    _, first = made
    pressure, change = first["pressure"].astype(float), first["change"].astype(float) / 16 - 128
    assert (pressure.max(axis=(1, 2)) > 1).all()
    assert (first["displacement"].max(axis=(1, 2)) > 0.1).all()
    steepest = np.abs(change).max(axis=(1, 2, 3))
    assert (steepest > 3 * np.median(np.abs(change), axis=(1, 2, 3))).all()


def test_validation_shares_neither_unit_nor_shape_with_training():
    train, check = TrainingPlan(presses=100_000), ValidationPlan()
    assert presses.FIRST_UNIT > 100
    assert train.units < presses.FIRST_VALIDATION_UNIT - presses.FIRST_UNIT
    assert train.shapes < presses.FIRST_VALIDATION_SHAPE
    assert check.shapes % 2 == 0


@pytest.mark.slow
def test_validation_presses_a_shape_in_its_pose_and_anywhere(tmp_path):
    plan = ValidationPlan(shapes=2, units=2, same_pose=2, any_pose=2)
    found = presses.validation_presses(plan, tmp_path)
    assert found["shape"].tolist() == [0] * 4 + [1] * 4 + [0] * 4 + [1] * 4
    assert found["unit"].tolist() == [0] * 8 + [1] * 8
    change = found["change"].astype(float) - 128
    same = np.corrcoef(change[0].ravel(), change[1].ravel())[0, 1]
    anywhere = np.corrcoef(change[2].ravel(), change[3].ravel())[0, 1]
    assert same > anywhere
    two = presses.validation_presses(ValidationPlan(shapes=2, units=2, same_pose=2, any_pose=2), tmp_path / "b", jobs=2)
    assert data_sha256(two) == data_sha256(found)


def test_sums_over_squares_are_exact():
    frame = np.random.default_rng(0).integers(0, 256, (256, 256, 3), dtype=np.uint8)
    expected = frame.reshape(64, 4, 64, 4, 3).astype(int).sum(axis=(1, 3)).transpose(2, 0, 1)
    np.testing.assert_array_equal(pooled(frame), expected)
    assert pooled(np.full((8, 8, 3), 255, np.uint8)).max() == 16 * 255


def test_any_height_can_be_pressed_and_nothing_cannot():
    unit = FVSightUnit(FVSightParameters(grid=32), 0)
    x, y = unit.grid.coordinates()
    ball = np.maximum(0.01 - (x**2 + y**2) / 0.04, 0)
    gap = gap_under(ball, unit, (0.0, 0.0), 0.056)
    assert gap.min() == 0
    assert np.isinf(gap[0, 0])
    np.testing.assert_allclose(gap[16, 20], ball.max() - ball[16, 20], atol=1e-9)
    with pytest.raises(ValueError, match="nothing higher than"):
        gap_under(np.zeros((32, 32)), unit, (0.0, 0.0), 0.056)
