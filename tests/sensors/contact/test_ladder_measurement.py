"""The measurement behind the ladder's table, and its file."""

from dataclasses import replace

import numpy as np
import pytest

from sensors.contact.ladder import RUNGS, Pad, committed_table, indenter, measure_ladder, read_table, write_table
from sensors.contact.ladder.flat import LayerRung
from sensors.contact.ladder.measure import displacement_error, sample
from sensors.contact.ladder.solid import NeoHookeanRung
from sensors.contact.layer import LayerMaterial

H = 3e-3
PAD = Pad(LayerMaterial(H, 1e5, 0.45), 8 * H)
COARSE = NeoHookeanRung("coarse", 6, 3, n=64)
SMALL = [RUNGS["winkler"], RUNGS["layer-64"], RUNGS["layer-128"], COARSE]


def test_measuring_gives_a_table_that_survives_the_disk(tmp_path):
    lines = []
    table = measure_ladder(
        [0.45],
        [8.0],
        ["sphere"],
        [0.1, 0.2],
        rungs=SMALL,
        reference=NeoHookeanRung("reference", 9, 4, n=64),
        coarser=COARSE,
        report=lines.append,
    )
    rows = {row.rung: row for row in table.rows}
    assert max(map(abs, rows["layer-128"].force_error)) < 0.06
    assert max(rows["layer-128"].displacement_error) < 0.1 < min(rows["winkler"].displacement_error)
    assert len(lines) == len(table.rows) + 1
    assert all(row.cost_ms > 0 for row in table.rows)
    write_table(table, tmp_path / "table.json")
    assert read_table(tmp_path / "table.json") == table


def test_a_rung_measured_against_itself_has_no_error():
    twin = NeoHookeanRung("twin", 6, 3, n=64)
    table = measure_ladder([0.41], [8.0], ["cylinder"], [0.1], rungs=[twin], reference=COARSE, coarser=COARSE)
    assert table.rows[0].force_error == (0.0,)
    assert table.rows[0].displacement_error == (0.0,)


def test_displacement_error_is_relative_and_indifferent_to_the_grid():
    surface = indenter("sphere", H)
    fine, rough = (
        next(LayerRung("layer", n, np.float64).open(PAD, "sphere").press_depths(surface, [0.2 * H])) for n in (96, 48)
    )
    assert displacement_error(fine, fine) == pytest.approx(0, abs=1e-12)
    assert displacement_error(replace(fine, displacement=1.1 * fine.displacement), fine) == pytest.approx(0.1)
    assert displacement_error(rough, fine) < 0.03
    x, y = fine.grid.coordinates()
    assert sample(2 * x - 3 * y, fine.grid, 0.3 * x, 0.5 * y) == pytest.approx(0.6 * x - 1.5 * y)


def test_a_broken_table_is_refused_in_one_line(tmp_path):
    path, table = tmp_path / "table.json", committed_table()
    path.write_text("{}")
    with pytest.raises(ValueError, match="not a ladder table"):
        read_table(path)
    write_table(replace(table, rows=(replace(table.rows[0], force_error=(0.1,)),)), path)
    with pytest.raises(ValueError, match="must hold"):
        read_table(path)
