"""The score of the contact models: errors shrink on finer grids, and the tables say what was measured."""

from dataclasses import replace

import pytest
from matplotlib.figure import Figure

from sensors.contact.ladder import committed_table
from sensors.contact.scoring import against_hyperelastic, compare_with_tamaas, score_closed_forms
from sensors.contact.scoring.closed_forms import finite_thickness
from sensors.contact.scoring.figure import _draw_ladder, draw_physics
from sensors.contact.scoring.hyperelastic import SolidRow, force_within
from sensors.contact.scoring.peer import PeerRow, has_tamaas


@pytest.fixture(scope="module")
def rows():
    return {(r.model, r.oracle, r.precision, r.grid): r for r in score_closed_forms((32, 64))}


def test_finer_grids_are_nearer_to_the_closed_forms(rows):
    for model, oracle in (
        ("half-space", "Hertz, pressure field"),
        ("half-space", "Hertz, force"),
        ("skin", "Navier, uniform load"),
        ("layer", "bonded sphere, a/h 0.2"),
    ):
        coarse, fine = (rows[model, oracle, "float64", n].error for n in (32, 64))
        assert 0 < fine < coarse < 0.3


def test_the_layer_knows_its_thickness_and_springs_do_not(rows):
    layer = rows["layer", "bonded sphere, a/h 0.4", "float64", 64]
    assert layer.error < 0.01
    assert rows["winkler", "bonded sphere, a/h 0.4", "float64", 64].error > 3 * layer.error
    assert finite_thickness(0.4) > 1.8


def test_precision_does_not_show_at_the_usual_tolerance(rows):
    for (model, oracle, precision, n), row in rows.items():
        if precision == "float32":
            assert row.error == pytest.approx(rows[model, oracle, "float64", n].error, rel=0.02, abs=1e-5)


def test_a_warm_solve_costs_less_than_a_cold_one(rows):
    solved = [row for row in rows.values() if row.cold_ms is not None and row.model != "winkler"]
    assert sum(row.warm_ms for row in solved) < sum(row.cold_ms for row in solved)


def test_the_worst_pad_counts():
    table = committed_table()
    row = next(r for r in against_hyperelastic() if (r.rung, r.indenter) == ("layer-128", "sphere"))
    own = [r for r in table.rows if (r.rung, r.indenter) == ("layer-128", "sphere")]
    for depth, worst in enumerate(row.force):
        assert abs(worst) == max(abs(r.force_error[depth]) for r in own)
    with pytest.raises(ValueError, match=r"\[8.0, 16.0\], not 3"):
        against_hyperelastic(3)


def test_what_is_within_two_per_cent_follows_the_table():
    table = committed_table()
    worst, within = force_within(0.02, 0.2, "layer-128")
    assert worst > 0.02
    assert "sphere" not in within
    perfect = tuple(replace(r, force_error=(0.0,) * 4) if r.indenter == "sphere" else r for r in table.rows)
    assert force_within(0.02, 0.2, "layer-128", replace(table, rows=perfect))[1] == ["sphere"]


@pytest.mark.skipif(not has_tamaas(), reason="the peer solver is an extra")
def test_both_solvers_are_equally_near_to_hertz():
    (row,) = compare_with_tamaas((32,), rounds=3)
    assert row.error == pytest.approx(row.peer_error, rel=0.05)
    assert 0 < row.error < 0.03
    assert row.ratio_low <= row.ratio <= row.ratio_high


def test_the_figure_holds_three_panels_with_and_without_the_peer(tmp_path, rows):
    peer = PeerRow(64, 0.005, 0.005, 8.0, 20.0, 2.5, 2.0, 3.0, 5)
    sizes = []
    for peers in ([], [peer]):
        path = draw_physics(tmp_path / f"{len(peers)}.png", against_hyperelastic(), list(rows.values()), peers, 3)
        assert path.read_bytes()[:4] == b"\x89PNG"
        sizes.append(path.stat().st_size)
    assert sizes[0] != sizes[1]


def test_a_point_is_hollow_where_the_reference_of_its_own_class_moved_more():
    axes = Figure().add_subplot()
    rows = [
        SolidRow("a", "sphere", (0.01, -0.02), (0.0, 0.0), (0.004, 0.004), 1.0),
        SolidRow("a", "punch", (0.01, -0.02), (0.0, 0.0), (0.03, 0.004), 1.0),
    ]
    _draw_ladder(axes, rows, 2)
    points = {line.get_marker(): line.get_markerfacecolor() != "white" for line in axes.lines if len(line.get_xdata())}
    assert points == {"o": True, "s": False}
    assert all(line.get_ydata()[0] == pytest.approx(2.0) for line in axes.lines if len(line.get_xdata()))
    names = axes.get_legend_handles_labels()[1]
    assert {"a", "sphere (reference moved 0.4%)", "punch (reference moved 3.0%)"} <= set(names)
