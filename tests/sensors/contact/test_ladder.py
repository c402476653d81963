"""The ladder: one interface over all rungs, and a chooser that obeys its table."""

from dataclasses import replace

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.ladder import (
    INDENTER_CLASSES,
    RUNGS,
    Pad,
    choose_rung,
    committed_table,
    get_rung,
    indenter,
)
from sensors.contact.ladder.solid import NeoHookeanRung
from sensors.contact.layer import LayerMaterial
from sensors.contact.neohookean import GridSurface, SweptSurface

H = 3e-3
PAD = Pad(LayerMaterial(H, 1e5, 0.45), 8 * H)
COARSE = NeoHookeanRung("coarse", 6, 3, n=64)
REPLAYED = (0.02, 0.04)
"""Bounds that only the hyperelastic rungs meet."""
SMALL = [RUNGS["winkler"], RUNGS["layer-64"], RUNGS["layer-128"], COARSE]


@pytest.fixture(scope="module")
def table():
    return committed_table()


def everywhere(table):
    """Every pad and class of the committed table."""
    keys = {(row.poisson_ratio, row.side_ratio, row.indenter) for row in table.rows}
    return [(Pad(LayerMaterial(H, 1e5, nu), side * H), name) for nu, side, name in sorted(keys)]


@pytest.mark.parametrize("rung", SMALL, ids=lambda rung: rung.name)
@pytest.mark.parametrize("name", ["sphere", "flat-punch"])
def test_every_rung_presses_to_depths_and_by_loads_alike(rung, name):
    opened, surface = rung.open(PAD, name), indenter(name, H)
    path = list(opened.press_depths(surface, [0.05 * H, 0.15 * H]))
    forces = [one.force_n for one in path]
    assert 0 < forces[0] < forces[1]
    for one in path:
        assert one.pressure.sum() * one.grid.cell_area_m2 == pytest.approx(one.force_n, rel=1e-4)
        assert (one.pressure >= 0).all()
        assert one.displacement.max() == pytest.approx(one.indentation_m, rel=0.15)
    again = list(opened.press_loads(surface, forces))
    assert [one.indentation_m for one in again] == pytest.approx([0.05 * H, 0.15 * H], rel=5e-3)


def test_rungs_agree_within_a_few_per_cent_and_know_their_names():
    surface = indenter("sphere", H)
    forces = [next(rung.open(PAD, "sphere").press_depths(surface, [0.1 * H])).force_n for rung in SMALL[1:]]
    assert forces == pytest.approx([forces[0]] * 3, rel=0.05)
    assert all(get_rung(name).name == name for name in RUNGS)
    with pytest.raises(ValueError, match="known: winkler"):
        get_rung("layer-65")


def test_a_heightfield_off_centre_is_pressed_on_the_whole_pad():
    """The same sphere 0.5 h aside: same force as at the centre, displacement moved with it."""
    grid = Grid(96, 8 * H)
    x, y = grid.coordinates()
    aside = GridSurface(grid, indenter("sphere", H).jet(x - 0.5 * H, y).gap, 3 * H)
    for rung in (RUNGS["layer-64"], NeoHookeanRung("whole", 6, 2, n=64)):
        response = next(rung.open(PAD, "sphere").press_depths(aside, [0.2 * H]))
        centred = next(rung.open(PAD, "sphere").press_depths(indenter("sphere", H), [0.2 * H]))
        assert response.force_n == pytest.approx(centred.force_n, rel=0.1)
        cx, _ = response.grid.coordinates()
        mass = np.maximum(response.displacement, 0)
        assert (mass * cx).sum() / mass.sum() == pytest.approx(0.5 * H, abs=0.1 * H)


def test_the_table_covers_every_rung_pad_and_class(table):
    for pad, name in everywhere(table):
        rungs = {
            row.rung
            for row in table.rows
            if (row.poisson_ratio, row.indenter) == (pad.material.poisson_ratio, name)
            and row.side_ratio == pytest.approx(pad.side_ratio)
        }
        assert set(RUNGS) == rungs
    assert {name for _, name in everywhere(table)} == set(INDENTER_CLASSES)


def forces_today(rung, pad, name, ratios):
    """Forces over E h^2."""
    path = get_rung(rung).open(pad, name).press_depths(indenter(name, H), [ratio * H for ratio in ratios])
    return np.array([one.force_n for one in path]) / (pad.material.youngs_modulus_pa * H**2)


def relative_forces(table, pad, name):
    """Forces of each rung over the reference's, as the table has them."""
    own = (pad.material.poisson_ratio, round(pad.side_ratio), name)
    return {
        row.rung: 1 + np.array(row.force_error)
        for row in table.rows
        if (row.poisson_ratio, row.side_ratio, row.indenter) == own
    }


def test_the_committed_table_is_what_the_flat_rungs_do_today(table):
    """Every pad and class: forces against the finest layer's, measured again without the reference."""
    for pad, name in everywhere(table):
        known = relative_forces(table, pad, name)
        finest = forces_today("layer-fine", pad, name, table.depth_ratios)
        for rung in ("winkler", "layer-64", "layer-128"):
            today = forces_today(rung, pad, name, table.depth_ratios) / finest
            assert today == pytest.approx(known[rung] / known["layer-fine"], rel=1e-3), (pad, name, rung)


REFERENCE_FORCES = {
    (0.41, "sphere"): 1.0547,
    (0.41, "flat-punch"): 1.7944,
    (0.41, "edge"): 1.1510,
    (0.41, "cylinder"): 2.3125,
    (0.45, "sphere"): 1.1589,
    (0.45, "flat-punch"): 1.9253,
    (0.45, "edge"): 1.2310,
    (0.45, "cylinder"): 2.6074,
}
"""Of the reference at d/h 0.3 on a pad of side 8, over E h^2."""


@pytest.mark.parametrize(("nu", "name"), REFERENCE_FORCES)
def test_the_committed_table_stands_on_the_forces_of_its_reference(table, nu, name):
    pad = Pad(LayerMaterial(H, 1e5, nu), 8 * H)
    implied = forces_today("layer-128", pad, name, [0.3])[0] / relative_forces(table, pad, name)["layer-128"][-1]
    assert implied == pytest.approx(REFERENCE_FORCES[nu, name], rel=1e-3)
    # the coarser mesh of the reference's change is the hyperelastic rung
    change = next(row for row in table.reference_change if (row.poisson_ratio, row.indenter) == (nu, name))
    assert relative_forces(table, pad, name)["neohookean"] == pytest.approx(1 + np.array(change.force_error))


@pytest.mark.parametrize(("nu", "name"), [(0.41, "sphere"), (0.45, "sphere"), (0.41, "cylinder")])
def test_a_coarse_hyperelastic_press_finds_the_force_that_the_table_implies(table, nu, name):
    """At d/h 0.2, where the linear layer is 3 to 7 % too soft: 8 x 4 cells meet the implied force to 1 %."""
    pad, ratio = Pad(LayerMaterial(H, 1e5, nu), 8 * H), 0.2
    layer = relative_forces(table, pad, name)["layer-128"][table.depth_ratios.index(ratio)]
    solid = next(NeoHookeanRung("coarse", 8, 4, n=16).open(pad, name).press_depths(indenter(name, H), [ratio * H]))
    implied = forces_today("layer-128", pad, name, [ratio])[0] / layer * pad.material.youngs_modulus_pa * H**2
    assert layer < 0.97
    assert solid.force_n == pytest.approx(implied, rel=0.01)


@pytest.mark.parametrize("known", [False, True], ids=["class alone", "its representative"])
def test_the_choice_is_within_the_bounds_and_nothing_cheaper_is(table, known):
    """What replays the representative alone counts where that presses."""
    for pad, name in everywhere(table):
        surface = indenter(name, H) if known else None
        own = (pad.material.poisson_ratio, name)
        moved = next(row for row in table.reference_change if (row.poisson_ratio, row.indenter) == own)
        for force, shape in [(0.5, 2.0), (0.08, 0.12), (0.04, 0.5)]:
            try:
                choice = choose_rung(pad, name, force, shape, surface=surface)
            except ValueError:
                continue
            assert choice.force_error <= force
            assert choice.displacement_error <= shape
            for row in table.rows:
                same_pad = row.side_ratio == pytest.approx(pad.side_ratio)
                offered = known or not RUNGS[row.rung].replays
                cheaper = offered and row.cost_ms < choice.cost_ms
                if (row.poisson_ratio, row.indenter) == own and same_pad and cheaper:
                    forces = np.abs(row.force_error) + np.abs(moved.force_error)
                    shapes = np.array(row.displacement_error) + moved.displacement_error
                    assert forces.max() > force or shapes.max() > shape


def test_changing_the_bound_changes_the_rung(table):
    loose = choose_rung(PAD, "sphere", 2.0, 2.0)
    tight = choose_rung(PAD, "sphere", 0.07, 0.2)
    tightest = choose_rung(PAD, "sphere", 0.02, 0.04)
    assert loose.rung == "winkler"
    assert tight.rung.startswith("layer")
    assert tightest.rung == "neohookean"
    assert loose.cost_ms < tight.cost_ms < tightest.cost_ms


def test_a_spoilt_entry_changes_the_choice(table):
    bounds = (PAD, "sphere", 0.07, 0.2)
    before = choose_rung(*bounds, table=table)
    for spoil in ({"force_error": (0.01, 0.01, 0.01, 0.5)}, {"displacement_error": (0.9, 0.0, 0.0, 0.0)}):
        rows = tuple(replace(row, **spoil) if row.rung == before.rung else row for row in table.rows)
        assert choose_rung(*bounds, table=replace(table, rows=rows)).rung != before.rung
    rows = tuple(replace(row, cost_ms=1e6) if row.rung == before.rung else row for row in table.rows)
    assert choose_rung(*bounds, table=replace(table, rows=rows)).rung != before.rung


def test_the_replaying_rung_is_taken_for_the_representative_of_its_class_alone(table):
    """Nothing else may be near it in cost at such a bound; what it would refuse to press it is not offered for."""
    x, y = Grid(96, 8 * H).coordinates()
    aside = GridSurface(Grid(96, 8 * H), indenter("sphere", H).jet(x - 0.5 * H, y).gap, 3 * H)
    wanted = (PAD, "sphere", *REPLAYED)
    taken = choose_rung(*wanted, surface=indenter("sphere", H))
    assert taken.rung == "neohookean-reduced"
    for other in (None, aside, indenter("sphere", 1.01 * H)):
        choice = choose_rung(*wanted, surface=other)
        assert choice.rung == "neohookean"
        assert choice.cost_ms > 10 * taken.cost_ms


@pytest.mark.parametrize("spoil", [{"force_error": (0.0, 0.0, 0.0, 0.5)}, {"displacement_error": (0.9, 0.0, 0.0, 0.0)}])
def test_a_spoilt_entry_of_the_replaying_rung_changes_the_choice(table, spoil):
    wanted = {"surface": indenter("sphere", H)}
    before = choose_rung(PAD, "sphere", *REPLAYED, **wanted, table=table)
    rows = tuple(replace(row, **spoil) if row.rung == "neohookean-reduced" else row for row in table.rows)
    assert before.rung == "neohookean-reduced"
    assert choose_rung(PAD, "sphere", *REPLAYED, **wanted, table=replace(table, rows=rows)).rung == "neohookean"
    gone = tuple(row for row in table.rows if row.rung != "neohookean-reduced")
    assert choose_rung(PAD, "sphere", *REPLAYED, **wanted, table=replace(table, rows=gone)).rung == "neohookean"


def test_shallow_presses_count_shallow_errors_only(table):
    shallow = choose_rung(PAD, "sphere", 0.5, 2.0, depth_ratio=0.1)
    row = next(
        row
        for row in table.rows
        if (row.rung, row.poisson_ratio, row.side_ratio, row.indenter) == (shallow.rung, 0.45, 8.0, "sphere")
    )
    deep = choose_rung(PAD, "sphere", 0.5, 2.0)
    assert shallow.rung == deep.rung == row.rung
    assert max(map(abs, row.force_error[:2])) <= shallow.force_error <= deep.force_error


def test_a_reference_that_still_moves_counts_against_every_rung(table):
    """No rung may be called better than what it was measured against."""
    tight = (PAD, "sphere", 0.07, 0.2)
    loose = tuple(replace(row, force_error=(0.2,) * 4) for row in table.reference_change)
    with pytest.raises(ValueError, match="no contact rung"):
        choose_rung(*tight, table=replace(table, reference_change=loose))


def test_modulus_and_scale_do_not_matter():
    scaled = Pad(LayerMaterial(11 * H, 7e6, 0.45), 88 * H)
    assert choose_rung(scaled, "cylinder", 0.1, 0.2) == choose_rung(PAD, "cylinder", 0.1, 0.2)


@pytest.mark.parametrize("name", INDENTER_CLASSES)
@pytest.mark.parametrize(("nu", "side"), [(0.43, 8), (0.45, 11), (0.42, 12)])
def test_between_measured_pads_the_worst_of_them_counts(table, name, nu, side):
    """A bound that one neighbour breaks takes another rung."""
    material = LayerMaterial(H, 1e5, nu)
    neighbours = [
        row
        for row in table.rows
        if row.indenter == name
        and row.poisson_ratio in ([0.45] if nu == 0.45 else [0.41, 0.45])
        and row.side_ratio in ([8.0] if side == 8 else [8.0, 16.0])
    ]
    for force in (0.3, 0.12, 0.1):
        try:
            choice = choose_rung(Pad(material, side * H), name, force, 2.0)
        except ValueError:
            continue
        worst = max(abs(error) for row in neighbours if row.rung == choice.rung for error in row.force_error)
        assert worst <= choice.force_error <= force


@pytest.mark.parametrize("size", [0.25, 0.7, 1.5])
def test_a_surface_of_another_size_than_measured_is_refused(size):
    """A ball of R = h / 2 is no ball of 2 h: springs fitted to that one are half too soft for it."""
    with pytest.raises(ValueError, match="not of the size measured as sphere"):
        choose_rung(PAD, "sphere", 0.2, 0.3, surface=SweptSurface(size * 2 * H))


def test_springs_are_offered_for_what_they_were_fitted_to_alone():
    """A ball a tenth smaller than the representative presses no springs; a layer it may."""
    loose = (PAD, "sphere", 2.0, 2.0)
    assert choose_rung(*loose).rung == choose_rung(*loose, surface=indenter("sphere", H)).rung == "winkler"
    assert choose_rung(*loose, surface=SweptSurface(1.8 * H)).rung.startswith("layer")


@pytest.mark.parametrize(
    ("pad", "name", "bounds", "message"),
    [
        (PAD, "spoon", (0.1, 0.1), "unknown indenter class"),
        (PAD, "sphere", (1e-6, 1e-6), "no contact rung"),
        (PAD, "sphere", (0.0, 0.1), "positive"),
        (Pad(LayerMaterial(H, 1e5, 0.2), 8 * H), "sphere", (0.1, 0.1), "poisson_ratio"),
        (Pad(LayerMaterial(H, 1e5, 0.38), 8 * H), "sphere", (0.2, 0.3), "poisson_ratio of 0.41 to 0.45, got 0.38"),
        (PAD, "sphere", (1e-9, 0.1), "within 1e-09 of the force"),
        (Pad(PAD.material, 200 * H), "sphere", (0.1, 0.1), "side over its thickness"),
        (Pad(PAD.material, 2 * H), "sphere", (0.1, 0.1), "side over its thickness"),
    ],
)
def test_what_was_not_measured_is_refused(pad, name, bounds, message):
    with pytest.raises(ValueError, match=message):
        choose_rung(pad, name, *bounds)


def test_deeper_than_measured_is_refused():
    with pytest.raises(ValueError, match="deepest measured"):
        choose_rung(PAD, "sphere", 0.1, 0.1, depth_ratio=0.6)
    for depth in (0.0, -1.0, np.nan):
        with pytest.raises(ValueError, match="must be positive"):
            choose_rung(PAD, "sphere", 0.1, 0.1, depth_ratio=depth)
