"""Every way to scan a matrix against Kirchhoff's laws written node by node, and the exact correction."""

from dataclasses import replace

import numpy as np
import pytest

from sensors.electronics.piezoresistive import PiezoresistiveChain
from sensors.electronics.scanning import correct_grounded_rows, scan

DIVIDER, SUPPLY = 10e3, 3.3
RNG = np.random.default_rng(0)
CONDUCTANCE = 10 ** RNG.uniform(-6, -3, (5, 4, 6))


def nodal_voltages(conductance: np.ndarray, driven: int, grounded: bool) -> np.ndarray:
    """Column voltages of one matrix (rows, columns) by nodal analysis of all rows and columns."""
    rows, columns = conductance.shape
    laplacian = np.zeros((rows + columns, rows + columns))
    for r in range(rows):
        for c in range(columns):
            a, b, g = r, rows + c, conductance[r, c]
            laplacian[[a, b], [a, b]] += g
            laplacian[[a, b], [b, a]] -= g
    laplacian[rows:, rows:] += np.eye(columns) / DIVIDER
    known = {driven: SUPPLY} | ({r: 0.0 for r in range(rows) if r != driven} if grounded else {})
    unknown = [node for node in range(rows + columns) if node not in known]
    current = -sum(laplacian[unknown, node] * value for node, value in known.items())
    return np.linalg.solve(laplacian[np.ix_(unknown, unknown)], current)[-columns:]


@pytest.mark.parametrize(("scanning", "grounded"), [("floating", False), ("grounded_rows", True)])
def test_crosstalk_is_that_of_the_resistor_network(scanning, grounded):
    voltage = scan(CONDUCTANCE, DIVIDER, SUPPLY, scanning)
    for matrix, seen in zip(CONDUCTANCE, voltage, strict=True):
        for row in range(4):
            assert seen[row] == pytest.approx(nodal_voltages(matrix, row, grounded), rel=1e-9)


def test_isolated_taxels_are_dividers_of_their_own():
    alone = np.zeros_like(CONDUCTANCE)
    alone[:, 1, 2] = CONDUCTANCE[:, 1, 2]
    together = scan(CONDUCTANCE, DIVIDER, SUPPLY, "isolated")[:, 1, 2]
    for scanning in ("isolated", "grounded_rows", "floating"):
        assert scan(alone, DIVIDER, SUPPLY, scanning)[:, 1, 2] == pytest.approx(together, rel=1e-12)


def test_the_correction_of_grounded_rows_is_exact():
    corrected = correct_grounded_rows(scan(CONDUCTANCE, DIVIDER, SUPPLY, "grounded_rows"), DIVIDER, SUPPLY)
    assert corrected == pytest.approx(CONDUCTANCE, rel=1e-9)


def test_three_pressed_corners_of_a_rectangle_raise_a_ghost_at_the_fourth_only_where_rows_float():
    load = np.zeros((1, 16))
    load[0, [0, 1, 4]] = 10.0
    ghosts = {}
    for scanning in ("isolated", "grounded_rows", "floating"):
        chain = replace(PiezoresistiveChain(), scanning=scanning, hysteresis=None)
        ghosts[scanning] = chain.read(load)[0, 5]
    assert ghosts["floating"] > 1.0
    assert ghosts["isolated"] == pytest.approx(0, abs=0.01)
    assert ghosts["grounded_rows"] == pytest.approx(0, abs=0.05)


def test_an_array_without_any_conductance_reads_zero_volts():
    for scanning in ("isolated", "grounded_rows", "floating"):
        assert (scan(np.zeros((2, 4, 4)), DIVIDER, SUPPLY, scanning) == 0).all()


def test_rows_that_do_not_fit_and_unknown_scans_are_refused():
    with pytest.raises(ValueError, match="16 taxels do not fill 5 rows"):
        PiezoresistiveChain(scanning="floating", rows=5).read(np.ones((3, 16)))
    with pytest.raises(ValueError, match="unknown scanning"):
        scan(CONDUCTANCE, DIVIDER, SUPPLY, "diagonal")
