"""Laws of kernel orthogonal matching pursuit."""

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from sklearn.linear_model import orthogonal_mp_gram

from fusion.gram import stored_gram
from fusion.kernels import linear_kernel, rbf_kernel
from fusion.komp import joint_komp, kernel_omp_gram


def dense(indices, coefs, n_atoms):
    codes = np.zeros((len(indices), n_atoms))
    rows, places = np.nonzero(indices >= 0)
    codes[rows, indices[rows, places]] = coefs[rows, places]
    return codes


def problem(seed=0, n=40, q=12, d=60, unit=True):
    rng = np.random.default_rng(seed)
    atoms, queries = rng.normal(size=(n, d)), rng.normal(size=(q, d))
    if unit:
        atoms /= np.linalg.norm(atoms, axis=1, keepdims=True)
    return atoms, queries


@pytest.mark.parametrize("k", [1, 3, 10, 25])
def test_equals_scikit_learn_on_a_linear_kernel_with_unit_atoms(k):
    atoms, queries = problem(k)
    G, K = atoms @ atoms.T, queries @ atoms.T
    indices, coefs, n_selected, _ = kernel_omp_gram(G, K, k)
    expected = orthogonal_mp_gram(G, K.T, n_nonzero_coefs=k).T
    assert np.all(n_selected == k)
    for row, wanted in zip(indices, expected, strict=True):
        assert set(row) == set(np.flatnonzero(wanted))
    np.testing.assert_allclose(dense(indices, coefs, len(G)), expected, rtol=0, atol=1e-12)


def test_without_normalisation_equals_scikit_learn_on_atoms_of_any_size():
    atoms, queries = problem(3, unit=False)
    atoms *= np.random.default_rng(4).uniform(0.1, 10, size=(len(atoms), 1))
    G, K = atoms @ atoms.T, queries @ atoms.T
    indices, coefs, _, _ = kernel_omp_gram(G, K, 8, normalize_atoms=False)
    expected = orthogonal_mp_gram(G, K.T, n_nonzero_coefs=8).T
    np.testing.assert_allclose(dense(indices, coefs, len(G)), expected, rtol=0, atol=1e-11)


def pursuit_in_80_digits(G, K, k):
    """Support and coefficients of one query, normal equations solved afresh at each step."""
    support: list[int] = []
    x = mpmath.matrix(0, 1)
    for _ in range(k):
        residual = [K[i] - sum(G[i, s] * x[j] for j, s in enumerate(support)) for i in range(G.rows)]
        size = [mpmath.mpf(-1) if i in support else abs(r) / mpmath.sqrt(G[i, i]) for i, r in enumerate(residual)]
        support.append(max(range(len(size)), key=lambda i: (size[i], -i)))
        block = mpmath.matrix([[G[a, b] for b in support] for a in support])
        x = mpmath.lu_solve(block, mpmath.matrix([K[s] for s in support]))
    return support, [float(v) for v in x]


@pytest.mark.parametrize(("gamma", "rtol"), [(0.3, 1e-12), (0.01, 1e-9)])
def test_agrees_with_an_80_digit_reference(gamma, rtol):
    rng = np.random.default_rng(5)
    atoms, queries = rng.normal(size=(12, 3)), rng.normal(size=(3, 3))
    indices, coefs, _, _ = kernel_omp_gram(rbf_kernel(atoms, atoms, gamma), rbf_kernel(queries, atoms, gamma), 4)
    with mpmath.workdps(80):

        def value(a, b):
            return mpmath.exp(
                -mpmath.mpf(gamma) * sum((mpmath.mpf(u) - mpmath.mpf(v)) ** 2 for u, v in zip(a, b, strict=True))
            )

        G = mpmath.matrix([[value(a, b) for b in atoms.tolist()] for a in atoms.tolist()])
        for row, x, query in zip(indices, coefs, queries.tolist(), strict=True):
            support, expected = pursuit_in_80_digits(G, [value(query, a) for a in atoms.tolist()], 4)
            assert row.tolist() == support
            np.testing.assert_allclose(x, expected, rtol=rtol)


def test_residual_is_orthogonal_to_the_selected_atoms_and_energy_is_the_projection():
    rng = np.random.default_rng(6)
    atoms, queries = rng.normal(size=(50, 8)), rng.normal(size=(9, 8))
    G, K = rbf_kernel(atoms, atoms, 0.05), rbf_kernel(queries, atoms, 0.05)
    indices, coefs, _, energy = kernel_omp_gram(G, K, 12)
    for row, x, k, e in zip(indices, coefs, K, energy, strict=True):
        block = G[np.ix_(row, row)]
        np.testing.assert_allclose(block @ x, k[row], atol=1e-10)
        assert e == pytest.approx(x @ block @ x, rel=1e-9)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), log_gamma=st.floats(-12, 3), pivot_tol=st.sampled_from(["auto", 0.0, 1e-12]))
@example(seed=261, log_gamma=-6.847299203463751, pivot_tol="auto")
def test_residual_energy_never_rises_with_k(seed, log_gamma, pivot_tol):
    rng = np.random.default_rng(seed)
    atoms, queries = rng.normal(size=(20, 4)), rng.normal(size=(5, 4))
    G, K = (rbf_kernel(x, atoms, 10.0**log_gamma) for x in (atoms, queries))
    codes = [kernel_omp_gram(G, K, k, pivot_tol=pivot_tol) for k in range(1, 21)]
    energies = np.array([energy for _, _, _, energy in codes])
    assert np.all(np.diff(energies, axis=0) >= 0)
    assert np.all(energies <= 1 + 1e-9)
    for (less, *_), (more, *_) in pairwise(codes):  # a larger k goes on where a smaller one ended
        assert np.all((less == more[:, :-1]) | (less < 0))
        assert np.all(more[:, -1][(less < 0).any(axis=1)] < 0)


@pytest.mark.parametrize("more", [0, 3, 30])
def test_a_second_atom_must_lie_200_eps_outside_the_first_however_many_are_asked_for(more):
    eps = np.finfo(float).eps
    for pivot, taken in ((150 * eps, 1), (300 * eps, 2)):
        G = np.eye(2 + more)
        G[0, 1] = G[1, 0] = np.sqrt(1 - pivot)
        K = np.zeros((1, 2 + more))
        K[0, :2] = 1.0, 0.5
        _, _, n_selected, _ = kernel_omp_gram(G, K, 2 + more)
        assert n_selected.tolist() == [taken]


def test_permuting_the_atoms_permutes_the_support():
    atoms, queries = problem(7)
    G, K = linear_kernel(atoms, atoms), linear_kernel(queries, atoms)
    order = np.random.default_rng(8).permutation(len(atoms))
    indices, coefs, _, energy = kernel_omp_gram(G, K, 9)
    moved = kernel_omp_gram(G[np.ix_(order, order)], K[:, order], 9)
    np.testing.assert_array_equal(order[moved[0]], indices)
    np.testing.assert_array_equal(moved[1], coefs)
    np.testing.assert_array_equal(moved[3], energy)


def test_chunks_and_threads_change_no_bit():
    rng = np.random.default_rng(9)
    atoms, queries = rng.normal(size=(70, 5)), rng.normal(size=(33, 5))
    grams = [rbf_kernel(atoms, atoms, g) for g in (0.1, 1.0)]
    kernels = [rbf_kernel(queries, atoms, g) for g in (0.1, 1.0)]
    gram, kernels = stored_gram(grams), np.stack(kernels)
    whole, energy = joint_komp(gram, kernels, 10, chunk=1000)
    for chunk, n_jobs in ((1, None), (7, 2), (32, 2), (None, -1)):
        codes, energies = joint_komp(gram, kernels, 10, chunk=chunk, n_jobs=n_jobs)
        for ours, reference in zip((*codes, energies), (*whole, energy), strict=True):
            np.testing.assert_array_equal(ours, reference)


def test_scaling_the_kernel_changes_no_support():
    atoms, queries = problem(10)
    G, K = linear_kernel(atoms, atoms), linear_kernel(queries, atoms)
    indices, coefs, _, _ = kernel_omp_gram(G, K, 9)
    for scale_g, scale_k in ((1e9, 1e9), (1e-9, 1e-9), (1.0, 1e9), (1e9, 1e-9)):
        scaled = kernel_omp_gram(scale_g * G, scale_k * K, 9)
        np.testing.assert_array_equal(scaled[0], indices)
        np.testing.assert_allclose(scaled[1], coefs * scale_k / scale_g, rtol=1e-9)


def test_ties_go_to_the_lowest_index():
    indices, coefs, n_selected, _ = kernel_omp_gram(np.eye(5), np.ones((1, 5)), 3)
    assert indices.tolist() == [[0, 1, 2]]
    assert coefs.tolist() == [[1.0, 1.0, 1.0]]
    assert n_selected.tolist() == [3]


@pytest.mark.parametrize("apart", [1, 8, 64, 200])
def test_of_equal_atoms_the_first_is_taken_at_every_step(apart):
    rng = np.random.default_rng(20)
    atoms, queries = rng.normal(size=(apart, 30)), rng.normal(size=(6, 30))
    pair = np.concatenate([atoms, atoms])
    indices, _, n_selected, _ = kernel_omp_gram(*(rbf_kernel(x, pair, 0.01) for x in (pair, queries)), 8)
    assert np.all(n_selected == min(8, apart))
    assert indices.max() < apart


@pytest.mark.parametrize("gamma", [1e-12, 1e-6, 1e-3, 1.0, 1e3])
def test_copies_of_atoms_are_never_taken_twice(gamma):
    rng = np.random.default_rng(11)
    base, queries = rng.normal(size=(6, 3)), rng.normal(size=(8, 3))
    atoms = np.concatenate([base, base, base])
    indices, coefs, n_selected, _ = kernel_omp_gram(*(rbf_kernel(x, atoms, gamma) for x in (atoms, queries)), 18)
    assert np.all(n_selected <= 6)
    assert indices.max() < 6
    assert np.isfinite(coefs).all()


def test_a_code_holds_no_more_atoms_than_the_rank():
    rng = np.random.default_rng(12)
    atoms = rng.normal(size=(30, 4)) @ rng.normal(size=(4, 50))
    queries = rng.normal(size=(10, 50))
    _, coefs, n_selected, _ = kernel_omp_gram(atoms @ atoms.T, queries @ atoms.T, 30)
    assert np.all(n_selected == 4)
    assert np.isfinite(coefs).all()


def test_more_coefficients_than_atoms_means_all_atoms():
    atoms, queries = problem(13, n=5)
    indices, _, n_selected, _ = kernel_omp_gram(atoms @ atoms.T, queries @ atoms.T, 100)
    assert indices.shape == (len(queries), 5)
    assert np.all(n_selected == 5)


def test_a_query_that_is_an_atom_takes_that_atom_alone():
    atoms, _ = problem(14)
    G = rbf_kernel(atoms, atoms, 0.5)
    indices, coefs, n_selected, energy = kernel_omp_gram(G, G, 10)
    np.testing.assert_array_equal(n_selected, 1)
    np.testing.assert_array_equal(indices[:, 0], np.arange(len(atoms)))
    np.testing.assert_array_equal(coefs[:, 0], 1.0)
    np.testing.assert_array_equal(energy, 1.0)


def test_zero_queries_take_no_atom_and_zero_atoms_are_never_taken():
    atoms, queries = problem(15)
    atoms[3] = 0
    queries[2] = 0
    indices, coefs, n_selected, energy = kernel_omp_gram(atoms @ atoms.T, queries @ atoms.T, len(atoms))
    assert n_selected[2] == 0
    assert energy[2] == 0
    assert np.all(indices[2] == -1)
    assert not np.any(indices == 3)
    assert np.isfinite(coefs).all()


def test_an_indefinite_gram_gives_a_finite_code():
    rng = np.random.default_rng(16)
    noise = rng.normal(size=(20, 20))
    _, coefs, n_selected, energy = kernel_omp_gram(noise + noise.T, rng.normal(size=(7, 20)), 20)
    assert np.isfinite(coefs).all()
    assert np.isfinite(energy).all()
    assert np.all(n_selected < 20)


def test_no_queries_give_empty_codes():
    indices, coefs, n_selected, energy = kernel_omp_gram(np.eye(3), np.empty((0, 3)), 2)
    assert (indices.shape, coefs.shape, n_selected.shape, energy.shape) == ((0, 2), (0, 2), (0,), (0,))


def test_float32_input_is_computed_in_float64():
    atoms, queries = problem(17)
    G, K = (linear_kernel(x, atoms).astype(np.float32) for x in (atoms, queries))
    doubled = kernel_omp_gram(G.astype(float), K.astype(float), 6)
    for ours, reference in zip(kernel_omp_gram(G, K, 6), doubled, strict=True):
        np.testing.assert_array_equal(ours, reference)


def test_a_modality_in_which_an_atom_is_dependent_gives_it_coefficient_zero():
    rng = np.random.default_rng(18)
    rich, queries = rng.normal(size=(6, 9)), rng.normal(size=(4, 9))
    poor = np.repeat(rng.normal(size=(1, 2)), 6, axis=0)
    codes, _ = joint_komp(
        stored_gram([linear_kernel(rich, rich), linear_kernel(poor, poor)]),
        np.stack([linear_kernel(queries, rich), linear_kernel(np.ones((4, 2)), poor)]),
        4,
    )
    np.testing.assert_array_equal(codes.n_selected, 4)
    assert np.all(codes.coefs[0] != 0)
    np.testing.assert_array_equal(codes.coefs[1][:, 1:], 0)
    assert np.all(codes.coefs[1][:, 0] != 0)


def test_two_equal_modalities_choose_as_one():
    rng = np.random.default_rng(19)
    atoms, queries = rng.normal(size=(25, 6)), rng.normal(size=(8, 6))
    G, K = rbf_kernel(atoms, atoms, 0.2), rbf_kernel(queries, atoms, 0.2)
    one, _ = joint_komp(stored_gram([G]), K[None], 6)
    two, _ = joint_komp(stored_gram([G, G]), np.stack([K, K]), 6, weights=[0.7, 0.3])
    np.testing.assert_array_equal(two.indices, one.indices)
    np.testing.assert_array_equal(two.coefs[0], one.coefs[0])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", ["G", "K"])
def test_values_that_are_not_finite_are_refused(bad, where):
    G, K = np.eye(4), np.ones((2, 4))
    (G if where == "G" else K)[1, 2] = bad
    with pytest.raises(ValueError, match=f"{where} holds values that are not finite"):
        kernel_omp_gram(G, K, 2)


@pytest.mark.parametrize(("own", "value"), [(1e-310, 1.0), (1e-320, 1e-10)])
def test_codes_that_no_number_holds_are_refused(own, value):
    with pytest.raises(ValueError, match="codes overflow"):
        kernel_omp_gram(own * np.eye(3), np.full((1, 3), value), 2)


def test_shapes_and_counts_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="G must be square"):
        kernel_omp_gram(np.ones((3, 4)), np.ones((2, 4)), 2)
    with pytest.raises(ValueError, match="one column per atom"):
        kernel_omp_gram(np.eye(3), np.ones((2, 4)), 2)
    with pytest.raises(ValueError, match="n_nonzero_coefs"):
        kernel_omp_gram(np.eye(3), np.ones((2, 3)), 0)
    with pytest.raises(ValueError, match="pivot_tol"):
        kernel_omp_gram(np.eye(3), np.ones((2, 3)), 1, pivot_tol=-1.0)
