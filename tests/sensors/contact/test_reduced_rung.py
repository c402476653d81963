"""The reduced rung behind the ladder's interface, and the tracing of its face onto a grid."""

from dataclasses import replace

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.ladder import Pad, indenter
from sensors.contact.ladder.reduced import NeoHookeanReducedRung
from sensors.contact.ladder.solid import contact_pressure, fitted_mesh
from sensors.contact.layer import LayerMaterial
from sensors.contact.neohookean import GridSurface, NeoHookeanPad, graded_pad
from sensors.contact.neohookean_reduced.face import face_on_grid

H = 3e-3
PAD = Pad(LayerMaterial(H, 1e5, 0.45), 8 * H)


def _rms(field):
    return np.sqrt(np.mean(field**2))


def test_a_stretched_face_is_traced_back_to_its_nodes():
    """u = (0.2 x, -0.1 y) with a depression linear in x and y: exact at every cell of a whole mesh."""
    pad = NeoHookeanPad(graded_pad(8 * H, H, (2 * H, 2 * H), 3, 2), PAD.material)
    rest = next(pad.press_depths(indenter("sphere", H), [0.0]))
    x, y, _ = pad.mesh.nodes.T
    displacement = np.stack([0.2 * x, -0.1 * y, 0.03 * x - 0.05 * y], axis=1)
    grid = Grid(20, 7 * H)
    down, pressure = face_on_grid(replace(rest, displacement=displacement), grid)
    cx, cy = grid.coordinates()
    assert down == pytest.approx(-0.03 * cx / 1.2 + 0.05 * cy / 0.9, abs=1e-6 * H)
    assert not pressure.any()


@pytest.mark.parametrize("n", [63, 64])
def test_tracing_back_gives_the_triangulated_face(n):
    """RMS difference 3 % of both fields on 8 cells (bilinear against triangles); the load kept to rounding."""
    surface = indenter("sphere", H)
    pad = NeoHookeanPad(fitted_mesh(PAD, surface, 8, 3), PAD.material)
    solution = next(pad.press_depths(surface, [0.2 * H]))
    grid = Grid(n, PAD.side_m)
    down, pressure = face_on_grid(solution, grid)
    assert _rms(down - solution.depression(grid)) < 0.03 * _rms(down)
    assert pressure.sum() * grid.cell_area_m2 == pytest.approx(solution.force_n, rel=1e-12)
    exact = contact_pressure(solution, grid)
    assert _rms(pressure - exact) < 0.03 * _rms(exact)
    assert down == pytest.approx(down.T, abs=1e-4 * down.max())
    assert down == pytest.approx(down[::-1, ::-1], abs=1e-12)


def test_the_rung_answers_like_the_full_one_and_refuses_other_indenters():
    """Edge at unseen depths on the same mesh: force within 1 %, displacement within 1 % (RMS)."""
    opened = NeoHookeanReducedRung("reduced", 6, 3, snapshots=10, modes=10).open(PAD, "edge")
    surface, depths = indenter("edge", H), [0.08 * H, 0.21 * H]
    exact = NeoHookeanPad(fitted_mesh(PAD, surface, 6, 3), PAD.material).press_depths(surface, depths)
    path = list(opened.press_depths(surface, depths))
    for own, full in zip(path, exact, strict=True):
        assert own.force_n == pytest.approx(full.force_n, rel=0.01)
        shape, _ = face_on_grid(full, own.grid)
        assert _rms(own.displacement - shape) < 0.01 * _rms(shape)
    by_load = list(opened.press_loads(surface, [one.force_n for one in path]))
    assert [one.indentation_m for one in by_load] == pytest.approx(depths, rel=0.01)
    with pytest.raises(ValueError, match="only the indenter and the axis"):
        next(opened.press_depths(indenter("sphere", H), depths))
    x, y = Grid(96, 8 * H).coordinates()
    moved = GridSurface(Grid(96, 8 * H), surface.jet(x - 0.2 * H, y).gap, 3 * H)
    with pytest.raises(ValueError, match="a contact that moved; train it for this one or use neohookean"):
        next(opened.press_loads(moved, [path[0].force_n]))
    with pytest.raises(ValueError, match="trained up to a depth"):
        next(opened.press_depths(surface, [0.31 * H]))
