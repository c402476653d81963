import numpy as np
import pytest

from sensors.objects import heightfield, names, place
from sensors.objects.raster import RASTER_N, RASTER_SIZE_M

REGION = 0.08
WHOLE = ("battery-aa", "coin-20-cent", "toy-duck", "earphone", "walnut", "key-round")
"""Objects that stay inside the region in the poses used here."""


@pytest.mark.parametrize("name", names())
def test_heightfield_is_the_mean_of_four_samples_of_the_height(name):
    from sensors.objects import get

    field = heightfield(name)
    pitch = RASTER_SIZE_M / RASTER_N
    rows, columns = np.random.default_rng(3).integers(0, RASTER_N, (2, 400))
    x, y = ((index + 0.5) * pitch - RASTER_SIZE_M / 2 for index in (columns, rows))
    quarter = pitch / 4
    corners = [get(name).height(x + i * quarter, y + j * quarter) for i in (-1, 1) for j in (-1, 1)]
    assert field.shape == (RASTER_N, RASTER_N)
    assert field.dtype == np.float32
    assert field[rows, columns] == pytest.approx(np.mean(corners, axis=0), abs=1e-8)
    assert np.isfinite(field).all()
    assert field.min() == 0.0


def test_heightfield_hands_out_its_own_copy():
    first = heightfield("spoon")
    first += 1.0
    assert heightfield("spoon").max() < 0.1


@pytest.mark.parametrize("name", names())
def test_centred_placement_is_the_block_mean_of_the_heightfield(name):
    edge = (RASTER_N - 512) // 2
    middle = heightfield(name)[edge : edge + 512, edge : edge + 512]
    for n in (64, 128, 256):
        block = 512 // n
        expected = middle.reshape(n, block, n, block).mean(axis=(1, 3))
        placed = place(name, n, REGION, 0.0, 0.0, 0.0)
        assert placed.dtype == np.float32
        assert placed.shape == (n, n)
        assert np.abs(placed - expected).max() < 2e-7


@pytest.mark.parametrize("name", WHOLE)
def test_a_full_turn_is_no_turn(name):
    still = place(name, 128, REGION, 1e-3, -2e-3, 0.3)
    turned = place(name, 128, REGION, 1e-3, -2e-3, 0.3 + 2 * np.pi)
    assert np.abs(turned - still).max() < 1e-7


@pytest.mark.parametrize("name", names())
def test_a_quarter_turn_takes_x_to_y(name):
    still = place(name, 128, REGION, 0.0, 0.0, 0.0)
    turned = place(name, 128, REGION, 0.0, 0.0, np.pi / 2)
    assert np.abs(turned - np.rot90(still, -1)).max() < 1e-6


@pytest.mark.parametrize("name", WHOLE)
def test_moving_by_whole_cells_moves_the_picture(name):
    still = place(name, 128, REGION, 0.0, 0.0, 0.7)
    pitch = REGION / 128
    moved = place(name, 128, REGION, 5 * pitch, -3 * pitch, 0.7)
    assert np.abs(moved[:-3, 5:] - still[3:, :-5]).max() < 2e-6


@pytest.mark.parametrize("name", WHOLE)
def test_mean_height_survives_turning_moving_and_coarsening(name):
    mean = heightfield(name).mean(dtype=float) * (RASTER_SIZE_M / REGION) ** 2
    for n in (48, 64, 100, 128, 256):
        for x, y, angle in ((0.0, 0.0, 0.4), (1.3e-3, -0.7e-3, 2.1), (-2e-3, 1.1e-3, -1.2)):
            assert place(name, n, REGION, x, y, angle).mean(dtype=float) == pytest.approx(mean, rel=2e-3)


def test_coarse_cells_are_means_of_fine_cells_in_any_pose():
    pose = (2.3e-3, -1.1e-3, 0.9)
    fine = place("comb", 256, REGION, *pose)
    coarse = place("comb", 64, REGION, *pose)
    assert np.abs(fine.reshape(64, 4, 64, 4).mean(axis=(1, 3)) - coarse).max() < 3e-5


@pytest.mark.parametrize("name", ["comb", "coin-1-euro", "shaver"])
def test_a_sensor_sees_the_middle_of_what_a_larger_one_sees(name):
    for x, y, angle in ((0.0, 0.0, 0.0), (0.031, -0.012, 0.8), (-0.045, 0.038, 2.9)):
        small = place(name, 64, REGION, x, y, angle)
        large = place(name, 112, 1.75 * REGION, x, y, angle)
        assert large.any()
        assert np.abs(large[24:-24, 24:-24] - small).max() < 2e-6


def test_the_table_lies_beyond_the_raster():
    far = place("fork", 128, REGION, 1.0, 1.0, 0.2)
    assert not far.any()
    wide = place("coin-1-euro", 128, 0.4, 0.0, 0.0, 0.0)
    assert wide.mean(dtype=float) * 0.4**2 == pytest.approx(
        heightfield("coin-1-euro").mean(dtype=float) * RASTER_SIZE_M**2, rel=0.02
    )


def test_same_call_same_bytes():
    pose = ("walnut", 128, REGION, 1e-3, 2e-3, 0.1)
    assert place(*pose).tobytes() == place(*pose).tobytes()


def test_bad_grids_and_poses_are_refused():
    with pytest.raises(ValueError, match="at least one cell"):
        place("spoon", 0, REGION, 0.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="positive side"):
        heightfield("spoon", 64, -1.0)
    with pytest.raises(ValueError, match="must be finite"):
        place("spoon", 64, REGION, float("nan"), 0.0, 0.0)
