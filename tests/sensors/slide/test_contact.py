"""The contact along a path: shapes, cells, interpolation against direct solves, and the skin in its own plane."""

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerMaterial
from sensors.fvsight import FVSightParameters, fvsight_unit
from sensors.slide.footprint import Footprint
from sensors.slide.membrane import in_plane_modulus, in_plane_skin
from sensors.slide.path import Path, gap_at
from sensors.slide.shapes import BODIES, body
from sensors.slide.track import CELL_M, Placed, lay_track, traction_modes

UNIT = fvsight_unit(FVSightParameters(tension_spread=0.0), 0)
FILM = UNIT.skin.film
LINE = Path(1e-3, -2e-3, 0.3, np.deg2rad(30.0), False)
TURN = Path(1e-3, -2e-3, 0.3, 0.0, True)


def placed(name, path=LINE):
    return Placed(UNIT, body(name), (0.002, -0.001), path)


def test_bodies_have_the_curvature_and_the_size_that_they_state():
    near = np.linspace(-1e-3, 1e-3, 101)
    flat = np.zeros_like(near)
    ball, cuboid, cylinder = (BODIES[name].height for name in ("ball", "cuboid", "cylinder"))
    assert np.polyfit(near, ball(near, flat), 2)[0] == pytest.approx(-1 / (2 * 20e-3), rel=1e-2)
    assert np.polyfit(near, cylinder(near, flat), 2)[0] == pytest.approx(-1 / (2 * 15e-3), rel=1e-2)
    assert np.ptp(cylinder(flat, near)) == 0
    assert np.ptp(cuboid(near, flat)) == 0
    x, y = Grid(400, 0.08).coordinates()
    for name, area in (("ball", np.pi * 20e-3**2), ("cuboid", 20e-3 * 30e-3), ("cylinder", 30e-3 * 45e-3)):
        inside = np.isfinite(BODIES[name].height(x, y)).sum() * 2e-4**2
        assert inside == pytest.approx(area, rel=0.03)
    with pytest.raises(ValueError, match="expected one of ball"):
        body("bal")


def test_paths_go_straight_or_turn():
    points = np.array([[2e-3, 1e-3], [0.0, -1e-3]])
    for path, travel in ((LINE, 4e-3), (TURN, 0.7)):
        there = path.to_sensor(points, travel)
        back = np.stack(path.to_object(there[:, 0], there[:, 1], travel), axis=-1)
        assert back == pytest.approx(points)
    x, y, heading = LINE.pose(np.array([0.0, 4e-3]))
    assert (np.diff(x), np.diff(y), np.diff(heading)) == (
        pytest.approx([4e-3 * np.cos(np.pi / 6)]),
        pytest.approx([2e-3]),
        pytest.approx([0]),
    )
    x, y, heading = TURN.pose(np.array([0.0, 0.7]))
    assert (np.diff(x), np.diff(y), np.diff(heading)) == (0, 0, pytest.approx([0.7]))


def test_a_gap_moves_with_its_body():
    grid = UNIT.grid
    there = gap_at(body("cuboid"), (0.0, 0.0), Path(0, 0, 0, 0, False), 0.0, grid)
    moved = gap_at(body("cuboid"), (0.0, 0.0), Path(0, 0, 0, 0, False), 4 * grid.pitch_m, grid)
    assert np.array_equal(moved[:, 4:], there[:, :-4])
    assert there.min() == 0
    tilted = gap_at(body("cuboid"), (0.01, 0.0), Path(0, 0, 0, 0, False), 0.0, grid)
    middle = grid.n // 2
    assert np.argmin(tilted[middle]) > middle


@pytest.mark.parametrize("name", list(BODIES))
def test_a_track_agrees_with_solves_at_places_between_its_own(name):
    travel = np.linspace(0, 6e-3, 40)
    load = np.full(40, 5.0)
    there = placed(name)
    track = lay_track(there, travel, load, there.solve(0.0, 5.0))
    smooth = track.taxel_load(travel, load)
    assert smooth.sum(axis=1) == pytest.approx(load, rel=0.01)
    for moment in (7, 22):
        direct = UNIT.taxel_load(there.solve(float(travel[moment]), 5.0).pressure)
        assert smooth[moment] == pytest.approx(direct, abs=0.02 * 5)
    assert (np.abs(np.diff(smooth, axis=0)) < 0.25).all()


def test_a_track_follows_a_turning_body():
    travel, load, there = np.linspace(0, 0.6, 30), np.full(30, 5.0), placed("cuboid", TURN)
    track = lay_track(there, travel, load, there.solve(0.0, 5.0))
    direct = UNIT.taxel_load(there.solve(float(travel[17]), 5.0).pressure)
    assert track.taxel_load(travel, load)[17] == pytest.approx(direct, abs=0.1)


def test_a_track_follows_the_load_through_zero():
    load, there = np.array([0.0, 0.6, 1.8, 3.5, 5.0]), placed("ball")
    track = lay_track(there, np.zeros(5), load, there.solve(0.0, 5.0), frames=True)
    smooth = track.taxel_load(np.zeros(5), load)
    assert smooth.sum(axis=1) == pytest.approx(load, rel=0.01)
    for moment in (2, 3):
        contact = there.solve(0.0, float(load[moment]))
        assert smooth[moment] == pytest.approx(UNIT.taxel_load(contact.pressure), abs=0.02 * 5)
        surface = UNIT.surface(track.modes(0.0, float(load[moment])))
        truth = UNIT.surface(UNIT.observe(contact).surface_modes)
        assert np.abs(surface - truth).max() < 0.05 * truth.max()
    assert (track.modes(0.0, 0.0) == 0).all()


@pytest.mark.parametrize("name", list(BODIES))
def test_cells_carry_the_load_where_the_pressure_is(name):
    there = placed(name)
    contact = there.solve(0.0, 5.0)
    track = lay_track(there, np.zeros(1), np.full(1, 5.0), contact)
    x, y = LINE.to_object(*UNIT.grid.coordinates(), 0.0)
    share = contact.pressure / contact.pressure.sum()
    carried = track.cell_share[0]
    assert carried.sum() == pytest.approx(1)
    assert carried @ track.cells.place == pytest.approx([(share * x).sum(), (share * y).sum()], abs=3e-5)
    assert track.cells.area.sum() == pytest.approx(contact.contact.sum() * UNIT.grid.cell_area_m2, rel=0.03)


def test_a_track_without_frames_has_no_modes():
    there = placed("ball")
    track = lay_track(there, np.zeros(1), np.full(1, 2.0), there.solve(0.0, 2.0))
    with pytest.raises(ValueError, match="without the modes"):
        track.modes(0.0, 2.0)


def disc_traction(grid, radius):
    x, y = grid.coordinates()
    disc = (x**2 + y**2 < radius**2).astype(float)
    return disc / (disc.sum() * grid.cell_area_m2)


def test_the_skin_gives_by_the_logarithm_of_the_contact():
    # mean displacement of a uniformly dragged disc far from the frame: (ln(R / c) + 1/4) / (2 pi K)
    film = LayerMaterial(1.5e-3, 5e6, 0.45)
    compliance = UNIT.compliance
    soft, radius = [], []
    for traction in (disc_traction(UNIT.grid, 4e-3), disc_traction(UNIT.grid, 8e-3)):
        soft.append(1 / in_plane_skin(UNIT.grid, film, 1.85, compliance.modes(traction)).stiffness)
        radius.append(np.sqrt(1 / (np.pi * traction.max())))
    expected = np.log(radius[1] / radius[0]) / (2 * np.pi * in_plane_modulus(film))
    assert soft[0] - soft[1] == pytest.approx(expected, rel=0.02)


def test_the_skin_that_moves_is_less_than_the_skin_there_is():
    contact = placed("cuboid").solve(0.0, 5.0)
    skin = in_plane_skin(UNIT.grid, FILM, 1.85, traction_modes(UNIT, contact))
    touched = contact.contact.sum() * UNIT.grid.cell_area_m2
    assert 1.85 * touched < skin.mass_kg < 1.85 * 0.08**2
    shape = UNIT.surface(skin.modes * skin.stiffness)
    share = contact.pressure / contact.pressure.sum()
    assert (share * shape).sum() == pytest.approx(1, rel=1e-3)


def test_the_footprint_agrees_with_the_array_and_keeps_the_sum():
    footprint = Footprint.of(FILM, UNIT.grid.size_m, CELL_M)
    rng = np.random.default_rng(0)
    place = rng.uniform(-30e-3, 30e-3, (6, 40, 2))
    load, shear = rng.normal(0, 0.1, (6, 40)), rng.normal(0, 0.1, (6, 40, 2))
    change = footprint.taxel_change(place, load, np.zeros_like(shear))
    assert change.sum(axis=1) == pytest.approx(load.sum(axis=1), abs=1e-9)
    assert footprint.taxel_change(place, 0 * load, shear).sum(axis=1) == pytest.approx(np.zeros(6), abs=1e-9)

    grid = UNIT.grid
    x, y = grid.coordinates()
    for centre in ((0.4e-3, 9e-3), (-19.0e-3, 0.2e-3)):
        patch = ((np.abs(x - centre[0]) < 3e-3) & (np.abs(y - centre[1]) < 2e-3)).astype(np.float32)
        newton = patch / (patch.sum() * grid.cell_area_m2)
        cells = np.stack((x[patch > 0], y[patch > 0]), axis=-1)[None]
        by_cells = footprint.taxel_change(
            cells, np.full(cells.shape[:2], 1 / cells.shape[1]), np.zeros((*cells.shape[:2], 2))
        )
        assert by_cells[0] == pytest.approx(UNIT.taxel_load(newton), abs=0.015)


def test_shear_tips_the_load_by_the_thickness_of_the_film():
    footprint = Footprint.of(FILM, UNIT.grid.size_m, CELL_M)
    place = np.array([[[0.5e-3, 3e-3], [2e-3, -1e-3]]])
    load, shear = np.array([[1.0, 0.5]]), np.array([[[0.02, 0.0], [0.0, -0.01]]])
    tipped = footprint.taxel_change(place, 0 * load, shear)
    # a little drag moves each load by h F_t / F_n
    moved = place + FILM.thickness_m * shear / load[..., None]
    shifted = footprint.taxel_change(moved, load, 0 * shear) - footprint.taxel_change(place, load, 0 * shear)
    assert tipped == pytest.approx(shifted, abs=4e-4)
    ahead = tipped.reshape(4, 4)[:, 2:].sum()
    assert ahead > 0


def test_long_histories_are_worked_on_in_parts():
    footprint = Footprint.of(FILM, UNIT.grid.size_m, CELL_M)
    rng = np.random.default_rng(1)
    place, load, shear = rng.normal(0, 5e-3, (4100, 2, 2)), rng.random((4100, 2)), rng.random((4100, 2, 2))
    whole = footprint.taxel_change(place, load, shear)
    assert whole[[0, 2000, 4099]] == pytest.approx(
        footprint.taxel_change(place[[0, 2000, 4099]], load[[0, 2000, 4099]], shear[[0, 2000, 4099]])
    )
