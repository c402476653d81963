"""The chooser of contact grids obeys its table, and a press scene obeys the chooser."""

from dataclasses import replace

import numpy as np
import pytest

from sensors.contact.ladder import committed_table
from sensors.contact.ladder.finite_strain import linear_error
from sensors.grids import choose_grid, committed_grids, read_grids, write_grids
from sensors.grids.choose import BOUNDS, measured_choices
from sensors.grids.measure import measure_grids
from sensors.press import simulate
from sensors.scene import PressScene
from sensors.sensor_card import describe

PLAIN = PressScene(id="plain", title="plain", objects=("coin-1-euro", "button"))
SKIN = PLAIN.sensor.model_dump()
CLASSES, LOADS = ("coin", "button"), (1.5, 5.0)

PAD = PLAIN.sensor.model_copy(update={"support": "plate", "film_thickness_mm": 4.0, "film_modulus_mpa": 0.3})
ON_PLATE = PAD.model_dump()


@pytest.fixture(scope="module")
def table():
    return committed_grids()


def bound_between(name, coarse, fine):
    """A bound that the finer of two grids meets and the coarser does not."""
    by_grid = {one.grid: getattr(one, name) for one in measured_choices(SKIN, CLASSES, LOADS)}
    assert by_grid[fine] < by_grid[coarse]
    return (by_grid[coarse] + by_grid[fine]) / 2


@pytest.mark.parametrize("name", BOUNDS)
def test_the_cheapest_grid_within_the_bound_is_taken(name):
    assert choose_grid(SKIN, CLASSES, LOADS, {name: 1e3}).grid == 64
    assert choose_grid(SKIN, CLASSES, LOADS, {name: bound_between(name, 64, 128)}).grid == 128
    assert choose_grid(SKIN, CLASSES, LOADS, {name: bound_between(name, 128, 256)}).grid == 256
    with pytest.raises(ValueError, match="the nearest is 256x256"):
        choose_grid(SKIN, CLASSES, LOADS, {name: 1e-9})


def test_a_spoilt_entry_changes_the_choice(table):
    bounds = {"frame": bound_between("frame", 64, 128)}
    taken = choose_grid(SKIN, CLASSES, LOADS, bounds, table).grid
    for spoil in ({"frame": 9.0}, {"cost_ms": 1e6}):
        rows = tuple(replace(row, **spoil) if row.grid == taken else row for row in table.rows)
        assert choose_grid(SKIN, CLASSES, LOADS, bounds, replace(table, rows=rows)).grid != taken
    moved = tuple(replace(row, frame=9.0) for row in table.reference_change)
    with pytest.raises(ValueError, match="no contact grid"):
        choose_grid(SKIN, CLASSES, LOADS, bounds, replace(table, reference_change=moved))


def test_the_bound_takes_the_model_where_a_pad_has_two(table):
    """Springs do for taxels, the layer where the surface counts; a hollow skin has no springs."""
    assert choose_grid(ON_PLATE, CLASSES, LOADS, {"force": 1.0}).contact == "springs"
    wide, narrow = (choose_grid(ON_PLATE, CLASSES, LOADS, {"force": 1.0, "displacement": one}) for one in (9.0, 0.2))
    assert (wide.contact, narrow.contact) == ("springs", "elastic")
    assert wide.cost_ms < narrow.cost_ms
    assert {one.contact for one in measured_choices(SKIN, CLASSES, LOADS)} == {"elastic"}


@pytest.mark.parametrize("spoil", [{"force": 9.0}, {"cost_ms": 1e6}])
def test_spoilt_springs_change_the_model(table, spoil):
    bounds = {"force": 1.0}
    assert choose_grid(ON_PLATE, CLASSES, LOADS, bounds, table).contact == "springs"
    rows = tuple(replace(row, **spoil) if row.contact == "springs" else row for row in table.rows)
    assert choose_grid(ON_PLATE, CLASSES, LOADS, bounds, replace(table, rows=rows)).contact == "elastic"


def on_plate(bound, **changes):
    return PressScene(**PLAIN.model_dump() | {"sensor": ON_PLATE, "error_bound": bound} | changes)


def test_a_bound_on_a_plate_counts_what_a_linear_film_leaves_out():
    """Bound = grid against the same linear film + linear against hyperelastic; a bound between the two is refused."""
    taken = choose_grid(ON_PLATE, CLASSES, LOADS, {"force": 1.0})
    grid_alone = {(one.grid, one.contact): one for one in measured_choices(ON_PLATE, CLASSES, LOADS)}[64, "springs"]
    finite = linear_error(grid_alone.depth_ratio, 0.45)
    assert (taken.grid, taken.contact) == (64, "springs")
    assert taken.force == pytest.approx(grid_alone.force + finite.force)
    assert taken.displacement == pytest.approx(grid_alone.displacement + finite.displacement)
    assert finite.force > 0.02
    for bound in (0.02, 1e-3):
        with pytest.raises(ValueError, match=r"nearest is .* of the force by finite strain of the film at d/h 0\.\d\d"):
            choose_grid(ON_PLATE, CLASSES, LOADS, {"force": bound})


def test_a_linear_film_is_further_off_the_deeper_and_unknown_beyond_what_was_measured():
    """Against the ladder's own rows: the worst class, the reference's change counted; between nus the worse."""
    ladder = committed_table()
    for nu in (0.41, 0.45):
        found = [linear_error(depth, nu).force for depth in ladder.depth_ratios]
        assert found == sorted(found)
        own = [row for row in ladder.rows if (row.rung, row.side_ratio, row.poisson_ratio) == ("layer-fine", 8.0, nu)]
        assert found[-1] > max(abs(error) for row in own for error in row.force_error)
    assert linear_error(0.11, 0.43).force == linear_error(0.2, 0.41).force
    for depth, nu, message in ((0.31, 0.45, "deeper than measured"), (np.nan, 0.45, "deeper"), (0.1, 0.49, "poisson")):
        with pytest.raises(ValueError, match=message):
            linear_error(depth, nu)


@pytest.mark.parametrize(
    ("bound", "objects", "message"),
    [
        ({"frame": 9.0}, ("button",), "frame cannot be kept on a plate"),
        ({"force": 0.025}, ("button",), "no contact grid is within"),
        ({"force": 0.06}, ("walnut",), "by finite strain of the film"),
    ],
)
def test_a_bound_that_a_linear_film_breaks_is_refused(bound, objects, message):
    with pytest.raises(ValueError, match=message):
        on_plate(bound, objects=objects)


def test_a_press_deeper_than_its_bound_counted_with_is_refused(table, monkeypatch):
    """The scene was measured to be shallow; the press itself says how deep it goes."""
    scene = on_plate({"force": 0.06}, objects=("button",))
    assert simulate(scene, 0, 0).indentation_mm < 0.1 * 4.0
    scene.keep_bound(0.09 * 4e-3)
    with pytest.raises(ValueError, match=r"pressed to 0\.25 .* of the force, .* \(error bound 0\.06\)"):
        scene.keep_bound(0.25 * 4e-3)
    with pytest.raises(ValueError, match="deeper than measured"):
        scene.keep_bound(0.5 * 4e-3)
    shallow = replace(table, rows=tuple(replace(row, depth_ratio=0.01) for row in table.rows))
    monkeypatch.setattr("sensors.grids.choose.committed_grids", lambda: shallow)
    finest = choose_grid(ON_PLATE, ("button",), LOADS, {"force": 0.0285, "displacement": 0.2})
    with pytest.raises(ValueError, match=r"error bound 0\.0285"):
        simulate(on_plate({"force": 0.0285, "displacement": 0.2}, objects=("button",)), 0, 0)
    assert finest.grid == 256


def test_a_scene_presses_with_the_model_of_its_bound():
    loose, tight = (
        PressScene(**PLAIN.model_dump() | {"sensor": ON_PLATE, "error_bound": bound})
        for bound in ({"force": 1.0}, {"displacement": 0.3})
    )
    assert [scene.effective_sensor().contact for scene in (loose, tight)] == ["springs", "elastic"]
    assert describe(loose)["parameters"]["contact"] == "springs"
    assert "contact" not in describe(tight)["parameters"]
    made = simulate(loose, 0, 0, ("displacement", "contact"))
    beside = made.truth["displacement"][~made.truth["contact"]]
    assert np.abs(beside).max() < 1e-3 * made.truth["displacement"].max()
    assert made.taxel_load.sum() == pytest.approx(made.total_force_n, rel=0.01)


def test_the_worst_class_counts(table):
    both = {one.grid: one for one in measured_choices(SKIN, CLASSES, LOADS)}
    for name in BOUNDS:
        alone = [{one.grid: one for one in measured_choices(SKIN, (kind,), LOADS)} for kind in CLASSES]
        for grid, one in both.items():
            assert getattr(one, name) == max(getattr(each[grid], name) for each in alone)


@pytest.mark.parametrize(
    ("change", "loads", "classes", "message"),
    [
        ({"film_thickness_mm": 9.0}, LOADS, CLASSES, "not measured for this sensor's pad"),
        ({}, (20.0,), CLASSES, "loads of"),
        ({}, LOADS, ("teapot",), "class 'teapot'"),
    ],
)
def test_what_was_not_measured_is_refused(change, loads, classes, message):
    with pytest.raises(ValueError, match=message):
        choose_grid(SKIN | change, classes, loads, {"force": 0.5})


def test_a_scene_takes_the_grid_of_its_bound_and_says_so():
    loose, tight = (
        PressScene(**PLAIN.model_dump() | {"error_bound": {"frame": bound}})
        for bound in (1e3, bound_between("frame", 64, 128))
    )
    assert loose.effective_sensor().grid == 64
    assert tight.effective_sensor().grid == 128
    assert describe(loose)["parameters"]["grid"] == 64
    assert simulate(loose, 0, 0, ("pressure",)).truth["pressure"].shape == (64, 64)
    assert PressScene(**loose.model_dump()) == loose


def test_a_bound_that_asks_for_the_sensors_own_grid_changes_nothing():
    bound = {"error_bound": {"frame": bound_between("frame", 64, 128)}}
    mine, plain = simulate(PressScene(**PLAIN.model_dump() | bound), 1, 0), simulate(PLAIN, 1, 0)
    assert np.array_equal(mine.image, plain.image)
    assert np.array_equal(mine.force_series, plain.force_series)


def test_a_scene_without_a_bound_does_not_speak_of_one():
    assert "error_bound" not in PLAIN.model_dump(mode="json")
    assert PLAIN.effective_sensor().grid == 128


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"error_bound": {}}, "at least one of"),
        ({"error_bound": {"force": -1}}, "greater than 0"),
        ({"error_bound": {"force": 0.5}, "sensor": {"grid": 64}}, "leave one of the two"),
        ({"error_bound": {"frame": 1e-9}}, "no contact grid"),
        ({"error_bound": {"force": 0.5}, "sensor": ON_PLATE | {"contact": "springs"}}, "leave one of the two"),
        ({"sensor": {"contact": "springs"}}, "a hollow skin has one model"),
    ],
)
def test_bounds_that_cannot_be_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        PressScene(id="s", title="s", objects=("button",), **changes)


def test_a_table_survives_the_disk_and_a_broken_one_is_named(table, tmp_path):
    path = tmp_path / "table.json"
    write_grids(table, path)
    assert read_grids(path) == table
    path.write_text('{"format": 2}')
    with pytest.raises(ValueError, match=r"table.json is not a table of contact grids .*python -m sensors.grids"):
        read_grids(path)


@pytest.mark.slow
def test_the_committed_table_is_what_the_grids_do_today(table):
    """Measured again with one object of a class of one."""
    again = measure_grids(("button",))
    kept = {(row.pad, row.grid, row.contact): row for row in table.rows if row.objects == "button"}
    assert len(again.rows) == len(kept) == 8
    for row in again.rows:
        for name in BOUNDS:
            known = getattr(kept[row.pad, row.grid, row.contact], name)
            assert getattr(row, name) == pytest.approx(known, rel=0.05, abs=2e-4)
        assert row.depth_ratio == pytest.approx(kept[row.pad, row.grid, row.contact].depth_ratio, rel=1e-3)
        assert (row.depth_ratio > 0) == (row.pad != "skin")
