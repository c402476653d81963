"""The hyperelastic solid and its elements: derivatives, rigid motion, patches and closed forms."""

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from scipy.optimize import brentq

from sensors.contact.layer import LayerMaterial
from sensors.contact.neohookean import HexMesh, NeoHookean, brick, graded_pad
from sensors.contact.neohookean.assembly import Assembly
from sensors.contact.neohookean.newton import minimise
from sensors.contact.neohookean.ordering import nested_dissection
from sensors.contact.solver import ConvergenceError

SOLID = NeoHookean(1.0, 9.0)


def box(cells=2, distorted=False) -> HexMesh:
    mesh = brick(*[np.linspace(0, 1, cells + 1)] * 3)
    if not distorted:
        return mesh
    inner = ((mesh.nodes > 0) & (mesh.nodes < 1)).all(axis=1)
    shift = np.random.default_rng(2).uniform(-0.1, 0.1, mesh.nodes.shape)
    return HexMesh(mesh.nodes + shift * inner[:, None], mesh.elements)


def assembly(mesh: HexMesh, solid: NeoHookean = SOLID, held: np.ndarray | None = None) -> Assembly:
    free = np.ones(mesh.nodes.shape, bool) if held is None else ~held
    return Assembly(mesh, solid, np.flatnonzero(free.ravel()))


class Boundary:
    """Stored energy over the free displacements, the held ones prescribed."""

    def __init__(self, mesh: HexMesh, solid: NeoHookean, held: np.ndarray, prescribed: np.ndarray) -> None:
        self.sums = assembly(mesh, solid, held)
        self.prescribed = prescribed

    def full(self, at):
        out = self.prescribed.copy()
        out.ravel()[self.sums.order] = at
        return out

    def energy(self, at):
        return self.sums.energy(self.full(at))

    def gradient(self, at):
        return self.sums.force(self.full(at)).ravel()[self.sums.order]

    def hessian(self, at):
        return self.sums.stiffness(self.full(at))[:-1, :-1]

    def solve(self, start=None):
        start = self.prescribed if start is None else start
        found = minimise(self, start.ravel()[self.sums.order], 1e-11, 1.0)
        return self.full(found.at)


def random_displacement(mesh, scale=0.05, seed=0):
    return scale * np.random.default_rng(seed).standard_normal(mesh.nodes.shape)


def test_force_is_the_slope_of_the_energy():
    sums = assembly(box(distorted=True))
    u, v = random_displacement(sums.mesh), random_displacement(sums.mesh, 1.0, 1)
    step = 1e-6
    slope = (sums.energy(u + step * v) - sums.energy(u - step * v)) / (2 * step)
    assert (sums.force(u) * v).sum() == pytest.approx(slope, rel=1e-8)


def test_tangent_is_the_slope_of_the_force():
    sums = assembly(box(distorted=True))
    u = random_displacement(sums.mesh)
    tangent = sums.stiffness(u)[:-1, :-1].toarray()
    step = 1e-6
    for dof in range(0, u.size, 7):
        v = np.zeros(u.size)
        v[dof] = step
        v = v.reshape(u.shape)
        slope = (sums.force(u + v) - sums.force(u - v)).ravel() / (2 * step)
        assert tangent[:, dof] == pytest.approx(slope, abs=1e-7 * np.abs(tangent).max())
    assert tangent == pytest.approx(tangent.T, abs=1e-12 * np.abs(tangent).max())


def test_a_rigid_motion_costs_nothing():
    sums = assembly(box(distorted=True))
    axis = np.array([[0, -0.6, 0.3], [0.6, 0, -0.5], [-0.3, 0.5, 0]])
    angle = np.sqrt(0.6**2 + 0.3**2 + 0.5**2)
    rotation = np.eye(3) + np.sin(angle) / angle * axis + (1 - np.cos(angle)) / angle**2 * axis @ axis
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-14)
    moved = sums.mesh.nodes @ rotation.T + [0.3, -2.0, 1.0]
    u = moved - sums.mesh.nodes
    assert sums.energy(u) == pytest.approx(0, abs=1e-13)
    assert sums.force(u) == pytest.approx(0, abs=1e-13)


def test_a_turned_body_has_turned_forces():
    sums = assembly(box(distorted=True))
    u = random_displacement(sums.mesh)
    quarter_turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    turned = (sums.mesh.nodes + u) @ quarter_turn.T - sums.mesh.nodes
    assert sums.energy(turned) == pytest.approx(sums.energy(u), rel=1e-12)
    assert sums.force(turned) == pytest.approx(sums.force(u) @ quarter_turn.T, abs=1e-12)


def test_patch_of_distorted_elements_holds_a_homogeneous_deformation():
    """Linear displacement on the boundary: the distorted interior follows it exactly, with no force inside."""
    mesh = box(3, distorted=True)
    slope = np.array([[0.1, 0.05, 0.0], [-0.1, 0.2, 0.1], [0.0, 0.15, -0.25]])
    linear = mesh.nodes @ slope.T
    edge = ((mesh.nodes == 0) | (mesh.nodes == 1)).any(axis=1)
    held = np.repeat(edge[:, None], 3, axis=1)
    problem = Boundary(mesh, SOLID, held, np.where(held, linear, 0.0))
    assert problem.solve(np.where(held, linear, 0.9 * linear)) == pytest.approx(linear, abs=1e-9)


def rollers(mesh: HexMesh, stretch: float, confined: bool) -> Boundary:
    held = mesh.nodes == 0
    held[:, 2] |= mesh.nodes[:, 2] == 1
    if confined:
        held[:, :2] |= mesh.nodes[:, :2] == 1
    prescribed = np.zeros_like(mesh.nodes)
    prescribed[mesh.nodes[:, 2] == 1, 2] = stretch - 1
    return Boundary(mesh, SOLID, held, prescribed)


def test_confined_compression_follows_its_closed_form():
    """F = diag(1, 1, l): P = mu l^(-2/3) (l - (2 + l^2) / (3 l)) + kappa (l - 1)."""
    for stretch in (0.9, 0.6, 1.3):
        problem = rollers(box(), stretch, confined=True)
        u = problem.solve(problem.prescribed + (stretch - 1) * problem.sums.mesh.nodes * [0, 0, 1])
        force = problem.sums.force(u)[problem.sums.mesh.nodes[:, 2] == 1, 2].sum()
        mu, kappa = SOLID.shear_modulus_pa, SOLID.bulk_modulus_pa
        exact = mu * stretch ** (-2 / 3) * (stretch - (2 + stretch**2) / (3 * stretch)) + kappa * (stretch - 1)
        assert force == pytest.approx(exact, rel=1e-9)


def test_uniaxial_compression_follows_its_closed_form():
    """Free sides: the lateral stretch b solves mu J^(-5/3) (b^2 - l^2) / 3 + kappa (J - 1) = 0, J = b^2 l."""
    mu, kappa = SOLID.shear_modulus_pa, SOLID.bulk_modulus_pa
    for stretch in (0.8, 1.4):

        def lateral(b, stretch=stretch):
            volume = b * b * stretch
            return mu * volume ** (-5 / 3) * (b * b - stretch**2) / 3 + kappa * (volume - 1)

        side = brentq(lateral, 0.3, 3.0, xtol=1e-14)
        volume = side**2 * stretch
        stress = mu * volume ** (-5 / 3) * (2 / 3) * (stretch**2 - side**2) + kappa * (volume - 1)
        problem = rollers(box(), stretch, confined=False)
        guess = problem.sums.mesh.nodes * [side - 1, side - 1, stretch - 1] * 0.95
        u = problem.solve(np.where(problem.prescribed != 0, problem.prescribed, guess))
        force = problem.sums.force(u)[problem.sums.mesh.nodes[:, 2] == 1, 2].sum()
        assert force == pytest.approx(stress * side**2, rel=1e-9)
        assert u[problem.sums.mesh.nodes[:, 0] == 1, 0] == pytest.approx(side - 1, rel=1e-8)


def test_small_strains_are_hookes():
    """Uniaxial: E and nu of the layer's material come back as force and lateral strain."""
    material = LayerMaterial(1.0, 3.0, 0.41)
    mesh, strain = box(), 1e-5
    problem = rollers(mesh, 1 - strain, confined=False)
    problem = Boundary(mesh, NeoHookean.from_layer(material), _held(problem), problem.prescribed)
    u = problem.solve()
    force = problem.sums.force(u)[mesh.nodes[:, 2] == 1, 2].sum()
    assert force == pytest.approx(-3.0 * strain, rel=1e-4)
    assert u[mesh.nodes[:, 1] == 1, 1] == pytest.approx(0.41 * strain, rel=1e-4)


def _held(problem: Boundary) -> np.ndarray:
    held = np.ones(problem.sums.mesh.nodes.size, bool)
    held[problem.sums.order] = False
    return held.reshape(-1, 3)


def test_bending_does_not_lock_as_volume_is_kept():
    """A bonded block sheared and squeezed: stiffness hardly changes from nu = 0.49 to 0.49999 (full Q1 doubles)."""
    mesh = graded_pad(4.0, 1.0, (2.0, 2.0), 5, 4, quarter=True)
    held = mesh.fixed()
    top = np.zeros(len(mesh.nodes), bool)
    top[mesh.top] = True
    middle = top & (np.hypot(mesh.nodes[:, 0], mesh.nodes[:, 1]) < 0.5)
    held[middle, 2] = True
    loads = []
    for nu in (0.49, 0.499, 0.49999):
        prescribed = np.zeros_like(mesh.nodes)
        prescribed[middle, 2] = -1e-3
        problem = Boundary(mesh, NeoHookean.from_layer(LayerMaterial(1.0, 3.0, nu)), held, prescribed)
        u = problem.solve()
        loads.append(-problem.sums.force(u)[middle, 2].sum())
    assert loads[1] == pytest.approx(loads[0], rel=0.03)
    assert loads[2] == pytest.approx(loads[1], rel=0.005)
    assert problem.sums.dilatation(u) == pytest.approx(1.0, abs=1e-6)


def test_energy_converges_with_the_square_of_the_cell():
    """A smooth dent of 0.2 h in the top of a bonded block: halving the cells quarters the error."""
    energies = []
    for cells in (4, 8, 16):
        lines = [np.linspace(0, 2, cells + 1)] * 2 + [np.linspace(0, 1, cells // 2 + 1)]
        mesh = brick(lines[0], lines[1], lines[2], quarter=True)
        held = mesh.fixed()
        held[mesh.top, 2] = True
        prescribed = np.zeros_like(mesh.nodes)
        x, y = mesh.nodes[mesh.top, :2].T
        prescribed[mesh.top, 2] = -0.2 * np.cos(np.pi * x / 4) ** 2 * np.cos(np.pi * y / 4) ** 2
        problem = Boundary(mesh, SOLID, held, prescribed)
        start = prescribed[mesh.top, 2].reshape(cells + 1, cells + 1, 1) * lines[2]
        u = problem.solve(np.stack([0 * start, 0 * start, start], axis=-1).reshape(-1, 3))
        energies.append(problem.sums.energy(u))
    assert (energies[0] - energies[1]) / (energies[1] - energies[2]) == pytest.approx(4, rel=0.2)


def test_inverted_elements_have_infinite_energy():
    sums = assembly(box(1))
    u = np.zeros_like(sums.mesh.nodes)
    u[:, 2] = -1.5 * sums.mesh.nodes[:, 2]
    assert sums.energy(u) == np.inf


def test_elimination_order_names_every_node_once_and_saves_fill():
    points = (13, 12, 5)
    order = nested_dissection(points)
    assert sorted(order) == list(range(np.prod(points)))
    mesh = brick(*[np.arange(float(count)) for count in points])
    fill = []
    for nodes in (np.arange(len(order)), order):
        dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        sums = Assembly(mesh, SOLID, dofs[~mesh.fixed().ravel()[dofs]])
        stiffness = sums.stiffness(np.zeros_like(mesh.nodes))[:-1, :-1]
        fill.append(spla.splu(stiffness, permc_spec="NATURAL", options={"SymmetricMode": True}).L.nnz)
    assert fill[1] < 0.85 * fill[0]


def test_a_rough_start_still_ends_at_the_minimum():
    """Random interior displacements need the line search; the answer is the homogeneous one."""
    problem = rollers(box(), 0.7, confined=True)
    start = problem.prescribed + random_displacement(problem.sums.mesh, 0.08)
    u = problem.solve(np.where(_held(problem), problem.prescribed, start))
    assert u == pytest.approx(-0.3 * problem.sums.mesh.nodes * [0, 0, 1], abs=1e-9)


def test_no_minimum_is_an_error():
    problem = rollers(box(1), 0.7, confined=False)
    with pytest.raises(ConvergenceError, match="residual"):
        minimise(problem, np.zeros(len(problem.sums.order)), 1e-30, 1.0, limit=3)


def test_impossible_solids_are_refused():
    with pytest.raises(ValueError, match=r"poisson_ratio < 0\.5"):
        NeoHookean.from_layer(LayerMaterial(1.0, 1.0, 0.5))
    with pytest.raises(ValueError, match="positive, finite"):
        NeoHookean(1.0, -1.0)
    with pytest.raises(ValueError, match="inverted"):
        HexMesh(box(1).nodes, box(1).elements[:, [4, 5, 6, 7, 0, 1, 2, 3]])
    with pytest.raises(ValueError, match="core_m"):
        graded_pad(1.0, 1.0, (2.0, 2.0), 4, 4)
