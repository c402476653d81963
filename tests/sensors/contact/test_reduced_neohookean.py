"""The reduced hyperelastic pad: equal to the full one with everything kept, close with little, refusing what is new."""

from dataclasses import replace

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerMaterial
from sensors.contact.neohookean import GridSurface, NeoHookeanPad, SweptSurface, graded_pad
from sensors.contact.neohookean.contact import TopContact
from sensors.contact.neohookean_reduced import pod_basis, sample_elements, train_reduced, training_depths
from sensors.contact.neohookean_reduced.__main__ import main
from sensors.contact.neohookean_reduced.measure import compare, top_error
from sensors.contact.neohookean_reduced.potential import ReducedPress
from sensors.contact.neohookean_reduced.store import load_reduced, save_reduced
from sensors.contact.neohookean_reduced.train import contributions

H, E = 2e-3, 3e5
SPHERE = SweptSurface(2 * H)
MATERIAL = LayerMaterial(H, E, 0.45)


def full_pad(cells=7, layers=3, quarter=True):
    return NeoHookeanPad(graded_pad(6 * H, H, (1.2 * H, 1.2 * H), cells, layers, quarter=quarter), MATERIAL)


@pytest.fixture(scope="module")
def pad():
    return full_pad()


@pytest.fixture(scope="module")
def reduced(pad):
    return train_reduced(pad, SPHERE, 0.25 * H, snapshots=14, modes=12)


@pytest.fixture(scope="module")
def unseen(pad, reduced):
    """Depths halfway between the trained ones, from the fourth on, and the full model there."""
    known = reduced.trained.depths_m[4:]
    depths = (known[:-1] + known[1:]) / 2
    return depths, list(pad.press_depths(SPHERE, depths))


def test_with_every_mode_and_element_it_is_the_full_solver():
    """Basis of unit vectors, all weights one: force and depth under both controls to 1e-4, shape to 2e-5 h."""
    pad = full_pad(4, 2)
    trained = train_reduced(pad, SPHERE, 0.25 * H, snapshots=2, tolerance=0)
    free = pad.assembly.order
    basis = np.zeros((pad.mesh.nodes.size, len(free)))
    basis[free, np.arange(len(free))] = 1.0
    fields = trained.trained.amplitudes @ trained.solid.basis.T
    whole = replace(
        trained,
        solid=replace(trained.solid, basis=basis),
        trained=replace(trained.trained, amplitudes=fields[:, free]),
        updates=12,
        gap_tolerance=1e-5,
    )
    exact = next(pad.press_depths(SPHERE, [0.17 * H]))
    by_depth = next(whole.press_depths(SPHERE, [0.17 * H]))
    by_load = next(whole.press_loads(SPHERE, [exact.force_n]))
    for one in (by_depth, by_load):
        assert one.force_n == pytest.approx(exact.force_n, rel=1e-4)
        assert one.indentation_m == pytest.approx(exact.indentation_m, rel=1e-4)
        assert one.displacement == pytest.approx(exact.displacement, abs=2e-5 * H)
        assert one.normal_load == pytest.approx(exact.normal_load, abs=1e-3 * exact.normal_load.max())


def test_unseen_depths_are_within_one_per_cent_of_force_and_two_of_displacement(reduced, unseen):
    depths, exact = unseen
    weights = reduced.solid.weights
    assert reduced.modes == 12
    assert 0 < (weights > 0).sum() < 0.5 * len(weights)
    for own, full in zip(reduced.press_depths(SPHERE, depths), exact, strict=True):
        assert own.force_n == pytest.approx(full.force_n, rel=0.01)
        assert top_error(own, full) < 0.02


def test_errors_fall_with_the_modes(pad, reduced, unseen):
    """All elements kept: root mean square errors of displacement and force fall from 3 over 6 to 12 modes."""
    depths, exact = unseen
    fields = (reduced.trained.amplitudes @ reduced.solid.basis.T)[1:]
    shapes, forces = [], []
    for modes in (3, 6, 12):
        basis = pod_basis(fields, modes)
        solid = replace(reduced.solid, basis=basis, weights=np.ones(len(pad.mesh.elements)))
        amplitudes = np.vstack([np.zeros(modes), fields @ basis])
        smaller = replace(reduced, solid=solid, trained=replace(reduced.trained, amplitudes=amplitudes))
        path = list(smaller.press_depths(SPHERE, depths))
        shapes.append(np.sqrt(np.mean([top_error(a, b) ** 2 for a, b in zip(path, exact, strict=True)])))
        forces.append(np.sqrt(np.mean([(a.force_n / b.force_n - 1) ** 2 for a, b in zip(path, exact, strict=True)])))
    assert shapes[0] > 1.5 * shapes[1] > 2 * shapes[2]
    assert forces[0] > 3 * forces[1] > 5 * forces[2]


def test_the_sample_of_elements_carries_the_force_and_the_energy(pad, reduced):
    """At a trained depth: reduced forces of the sample within 0.3 % of those of all elements, energy within 1 %."""
    every = replace(reduced.solid, weights=np.ones(len(pad.mesh.elements)))
    amplitudes = reduced.trained.amplitudes[-3]
    sampled = reduced.solid
    force, exact = (solid.force(solid.strain(amplitudes)) for solid in (sampled, every))
    assert np.linalg.norm(force - exact) < 3e-3 * np.linalg.norm(exact)
    energy, stored = (solid.energy(solid.strain(amplitudes)) for solid in (sampled, every))
    assert energy == pytest.approx(stored, rel=0.01)
    assert stored == pytest.approx(pad.assembly.energy((every.basis @ amplitudes).reshape(-1, 3)), rel=1e-12)


def test_gradient_and_tangent_are_derivatives(pad, reduced):
    for load in (None, 0.05):
        contact = TopContact(pad.mesh, SPHERE, reduced.trained.normal_load[-2], np.full(len(pad.mesh.top), 50.0))
        press = ReducedPress(reduced.solid, contact, 0.2 * H, load)
        at = press.pack(reduced.trained.amplitudes[-2])
        v = np.random.default_rng(0).standard_normal(len(at)) * np.abs(at).max()
        step = 1e-5
        slope = (press.energy(at + step * v) - press.energy(at - step * v)) / (2 * step)
        assert press.gradient(at) @ v == pytest.approx(slope, rel=1e-6, abs=1e-6 * np.abs(press.gradient(at) * v).max())
        bend = (press.gradient(at + step * v) - press.gradient(at - step * v)) / (2 * step)
        assert press.hessian(at) @ v == pytest.approx(bend, abs=1e-5 * np.abs(bend).max())


def test_load_and_depth_control_agree_and_order_does_not_matter(reduced):
    depths = np.array([0.2, 0.03, 0.11]) * H
    path = list(reduced.press_depths(SPHERE, depths))
    backwards = list(reduced.press_depths(SPHERE, depths[::-1]))[::-1]
    for one, other in zip(path, backwards, strict=True):
        assert (one.displacement == other.displacement).all()
    by_load = list(reduced.press_loads(SPHERE, [one.force_n for one in path]))
    assert [one.indentation_m for one in by_load] == pytest.approx(depths, rel=5e-3)


def test_trained_depths_come_back(reduced):
    """The last trained depth: force within 0.5 % of the snapshot's, and deeper is heavier all the way."""
    known = reduced.trained
    forces = [one.force_n for one in reduced.press_depths(SPHERE, known.depths_m[1:])]
    assert forces[-1] == pytest.approx(known.forces_n[-1], rel=5e-3)
    assert (np.diff(forces) > 0).all()
    assert training_depths(0.25 * H, 14) == pytest.approx(known.depths_m[1:])


def test_no_depth_and_no_load_are_at_rest(reduced):
    for solution in (*reduced.press_depths(SPHERE, [0.0, -1e-3]), next(reduced.press_loads(SPHERE, [0.0]))):
        assert solution.force_n == 0
        assert not solution.displacement.any()


def test_what_it_was_not_trained_with_is_refused(reduced):
    """Another indenter, another place, deeper, heavier: one line that says which."""
    with pytest.raises(ValueError, match="only the indenter and the axis"):
        next(reduced.press_depths(SweptSurface(1.9 * H), [0.1 * H]))
    grid = Grid(96, 6 * H)
    x, y = grid.coordinates()
    moved = GridSurface(grid, SPHERE.jet(x - 0.1 * H, y).gap, 10 * H)
    with pytest.raises(ValueError, match="contact that moved"):
        next(reduced.press_depths(moved, [0.1 * H]))
    with pytest.raises(ValueError, match="trained up to a depth"):
        next(reduced.press_depths(SPHERE, [0.26 * H]))
    with pytest.raises(ValueError, match="trained up to a load"):
        next(reduced.press_loads(SPHERE, [1.01 * reduced.trained.forces_n[-1]]))
    for bad in (np.nan, np.inf):
        with pytest.raises(ValueError, match="depth"):
            next(reduced.press_depths(SPHERE, [bad]))
        with pytest.raises(ValueError, match="load must be"):
            next(reduced.press_loads(SPHERE, [bad]))


def test_training_needs_a_path(pad):
    with pytest.raises(ValueError, match="two snapshots"):
        train_reduced(pad, SPHERE, 0.1 * H, snapshots=1)
    with pytest.raises(ValueError, match="positive depth"):
        train_reduced(pad, SPHERE, 0.0)
    with pytest.raises(ValueError, match="at least one mode"):
        pod_basis(np.eye(3), 0)
    with pytest.raises(ValueError, match="not at rest"):
        pod_basis(np.zeros((2, 3)), 1)


def test_the_basis_is_orthonormal_and_best_in_the_mean_square():
    """What is left of unit-length snapshots is the tail of their singular values (Eckart and Young)."""
    rng = np.random.default_rng(1)
    snapshots = rng.standard_normal((6, 3)) @ rng.standard_normal((3, 40)) + 0.1 * rng.standard_normal((6, 40))
    basis = pod_basis(snapshots, 3)
    assert basis.T @ basis == pytest.approx(np.eye(3), abs=1e-12)
    unit = snapshots / np.linalg.norm(snapshots, axis=1, keepdims=True)
    values = np.linalg.svd(unit, compute_uv=False)
    assert np.linalg.norm(unit - unit @ basis @ basis.T) == pytest.approx(np.sqrt((values[3:] ** 2).sum()), rel=1e-9)
    assert pod_basis(np.ones((4, 9)), 3).shape == (9, 1)


def test_a_sample_keeps_the_sums_with_few_weights_none_negative():
    """Rank 5 sums over 300 elements: at most 6 weights, sums to 1e-8, the total weight kept; tolerance 0 keeps all."""
    rng = np.random.default_rng(2)
    table = rng.standard_normal((40, 5)) @ rng.standard_normal((5, 300))
    weights = sample_elements(table, 1e-10)
    assert (weights >= 0).all()
    assert 0 < (weights > 0).sum() <= 6
    assert table @ weights == pytest.approx(table.sum(axis=1), abs=1e-8 * np.abs(table.sum(axis=1)).max())
    assert weights.sum() == pytest.approx(300)
    assert (sample_elements(table, 0.0) == 1).all()


def test_contributions_of_the_elements_sum_to_the_reduced_force(pad, reduced):
    amplitudes = reduced.trained.amplitudes[-1:]
    table = contributions(pad, reduced.solid.basis, amplitudes)
    nodal = pad.assembly.force((reduced.solid.basis @ amplitudes[0]).reshape(-1, 3))
    assert table.sum(axis=1) == pytest.approx(reduced.solid.basis.T @ nodal.ravel(), rel=1e-9, abs=1e-12)


def test_a_trained_pad_survives_the_disk_and_a_broken_file_is_refused(reduced, tmp_path):
    path = tmp_path / "sphere.npz"
    save_reduced(reduced, path)
    assert [file.name for file in tmp_path.iterdir()] == ["sphere.npz"]
    own, read = (next(one.press_depths(SPHERE, [0.12 * H])) for one in (reduced, load_reduced(path)))
    assert (own.displacement == read.displacement).all()
    broken = tmp_path / "broken.npz"
    broken.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(ValueError, match="not a trained reduced pad"):
        load_reduced(broken)
    np.savez(broken, format=np.array(1))
    with pytest.raises(ValueError, match="not a trained reduced pad"):
        load_reduced(broken)


def test_whole_meshes_reduce_like_quarters():
    """The same sphere on a whole, unsymmetric-capable mesh: forces of both reduced pads within 0.5 %."""
    forces = []
    for quarter in (True, False):
        pad = full_pad(4, 2, quarter=quarter)
        own = train_reduced(pad, SPHERE, 0.2 * H, snapshots=5, modes=5)
        forces.append([one.force_n for one in own.press_depths(SPHERE, [0.09 * H, 0.18 * H])])
    assert forces[1] == pytest.approx(forces[0], rel=5e-3)


def test_the_command_prints_the_errors_and_writes_the_pad(tmp_path, capsys):
    out = tmp_path / "edge.npz"
    small = ["--cells", "4", "--layers", "2", "--snapshots", "4", "--modes", "4", "--depth", "0.15"]
    main(["--indenter", "edge", *small, "-o", str(out)])
    printed = capsys.readouterr().out
    assert "4 modes" in printed
    assert "CPU a step" in printed
    rows = [line.split() for line in printed.splitlines()[2:5]]
    assert [float(row[2]) for row in rows] == pytest.approx([float(row[1]) for row in rows], rel=0.05)
    assert load_reduced(out).modes == 4
    with pytest.raises(SystemExit, match="unknown indenter class"):
        main(["--indenter", "spoon"])


def test_a_comparison_is_at_unseen_depths_and_its_errors_are_relative(pad, reduced, unseen):
    result = compare(pad, reduced, SPHERE, repeats=1)
    depths, exact = unseen
    assert result.depths_m[3:] == pytest.approx(depths)
    assert result.full_n[3:] == pytest.approx([one.force_n for one in exact], rel=1e-4)
    own = [one.force_n for one in reduced.press_depths(SPHERE, depths)]
    assert result.force_error[3:] == pytest.approx(
        [a / b.force_n - 1 for a, b in zip(own, exact, strict=True)], abs=1e-4
    )
    exact = next(pad.press_depths(SPHERE, [0.1 * H]))
    assert top_error(exact, exact) == 0
    assert top_error(replace(exact, displacement=1.1 * exact.displacement), exact) == pytest.approx(0.1)
