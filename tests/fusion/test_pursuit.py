"""The compiled pursuit against a plain NumPy form of the same algorithm, and Gram rows on demand."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.distance import cdist

import fusion
from fusion import KSC
from fusion.arrays import frozen
from fusion.gram import gram_on_demand, stored_gram
from fusion.kernels import linear_kernel, rbf_kernel
from fusion.komp import joint_komp
from fusion.pursuit import pursue

EPS = np.finfo(float).eps


def solve_transposed(lower, values):
    """x of L' x = values, one after the other from the last."""
    x = np.zeros(len(values))
    for j in reversed(range(len(values))):
        rest = values[j]
        for later in range(j + 1, len(values)):
            rest -= lower[later, j] * x[later]
        x[j] = rest / lower[j, j]
    return x


def plain_pursuit(grams, kernels, k, weights):
    """Simultaneous kernel OMP of one query, whole rows at a time: support, coefficients (M, k), energies (M,)."""
    n = len(kernels[0])
    correlations = [kernel.copy() for kernel in kernels]
    diagonals = [gram.diagonal() for gram in grams]
    scales = [np.sqrt(w) / np.sqrt(d) for w, d in zip(weights, diagonals, strict=True)]
    basis = np.zeros((len(grams), k, n))
    lower, projections = np.zeros((len(grams), k, k)), np.zeros((len(grams), k))
    energy, smallest = np.zeros(len(grams)), np.ones(len(grams))
    support = []
    for step in range(k):
        sizes = [np.abs(c) * s for c, s in zip(correlations, scales, strict=True)]
        score = sizes[0] if len(sizes) == 1 else np.sqrt(sum(size**2 for size in sizes))
        score[support] = 0
        atom = int(np.argmax(score))
        if step == 0:
            first = score[atom]
        if not (score[atom] > 8 * EPS * first and score[atom] > 0):
            break
        independent = False
        for m, gram in enumerate(grams):
            row = gram[atom].copy()
            for earlier in range(step):
                lower[m, step, earlier] = basis[m, earlier, atom]
                row -= basis[m, earlier, atom] * basis[m, earlier]
            pivot, own = row[atom], diagonals[m][atom]
            usable = pivot > 100 * (step + 1) * EPS * own
            if usable:
                smallest[m] = min(smallest[m], pivot / own)
            if usable and smallest[m] < 1e-4:
                w = solve_transposed(lower[m, :step, :step], lower[m, step, :step])
                size = np.sqrt(own)
                for place, chosen in enumerate(support):
                    size += abs(w[place]) * np.sqrt(diagonals[m][chosen])
                usable = pivot > 8 * EPS * size**2
            root = np.sqrt(pivot) if usable else 1.0
            lower[m, step, step] = root
            if usable:
                independent = True
                projections[m, step] = correlations[m][atom] / root
                energy[m] += projections[m, step] ** 2
                basis[m, step] = row * (1.0 / root)
                correlations[m] -= projections[m, step] * basis[m, step]
        if not independent:
            break
        support.append(atom)
    size = len(support)
    coefs = [solve_transposed(lower[m, :size, :size], projections[m, :size]) for m in range(len(grams))]
    return support, np.array(coefs), energy


def sets(seed, n_atoms, gammas, n_queries=6):
    rng = np.random.default_rng(seed)
    pairs = [(rng.normal(size=(n_atoms, 4)), rng.normal(size=(n_queries, 4)), gamma) for gamma in gammas]
    return [rbf_kernel(a, a, g) for a, _, g in pairs], np.stack([rbf_kernel(q, a, g) for a, q, g in pairs])


@pytest.mark.parametrize("n_atoms", [1, 7, 63, 64, 65, 1030, 2100])
@pytest.mark.parametrize("gammas", [(0.3,), (1e-6,), (1e3,), (0.3, 2.0), (1e-4, 0.1, 1.0)], ids=str)
def test_equals_the_plain_form_to_the_bit(n_atoms, gammas):
    grams, kernels = sets(len(gammas), n_atoms, gammas)
    weights = np.linspace(1.0, 0.3, len(gammas))
    k = min(10, n_atoms)
    codes, energy = joint_komp(stored_gram(grams), kernels, k, weights=weights)
    for q in range(kernels.shape[1]):
        support, coefs, wanted = plain_pursuit(grams, kernels[:, q], k, weights)
        assert codes.indices[q, : codes.n_selected[q]].tolist() == support
        np.testing.assert_array_equal(codes.coefs[:, q, : len(support)], coefs)
        np.testing.assert_array_equal(energy[:, q], wanted)


def test_atoms_of_every_size_equal_the_plain_form_to_the_bit():
    rng = np.random.default_rng(3)
    atoms = rng.normal(size=(1500, 30)) * rng.uniform(0.01, 100, size=(1500, 1))
    G, K = linear_kernel(atoms, atoms), linear_kernel(rng.normal(size=(5, 30)), atoms)
    codes, _ = joint_komp(stored_gram([G]), K[None], 10)
    for q, kernel in enumerate(K):
        support, coefs, _ = plain_pursuit([G], [kernel], 10, [1.0])
        assert codes.indices[q].tolist() == support
        np.testing.assert_array_equal(codes.coefs[:, q], coefs)


def test_distances_are_summed_in_the_order_of_the_columns():
    rng = np.random.default_rng(4)
    X, Y = rng.normal(size=(5, 37)), rng.normal(size=(1300, 37))
    np.testing.assert_allclose(rbf_kernel(X, Y, 0.1), np.exp(-0.1 * cdist(X, Y, "sqeuclidean")), rtol=1e-13)


@pytest.mark.parametrize("gammas", [(0.2,), (0.2, 1.0)], ids=str)
def test_rows_on_demand_choose_the_same_atoms(gammas):
    rng = np.random.default_rng(5)
    parts = [rng.normal(size=(300, 5)) for _ in gammas]
    kernels = np.stack([rbf_kernel(rng.normal(size=(20, 5)), a, g) for a, g in zip(parts, gammas, strict=True)])
    stored = stored_gram([rbf_kernel(a, a, g) for a, g in zip(parts, gammas, strict=True)])
    ones = [np.ones(300)] * len(parts)
    lean = gram_on_demand([a.T for a in parts], gammas, ones, ones)
    expected, energy = joint_komp(stored, kernels, 10)
    codes, energies = joint_komp(lean, kernels, 10)
    np.testing.assert_array_equal(codes.indices, expected.indices)
    np.testing.assert_allclose(codes.coefs, expected.coefs, atol=1e-12)
    np.testing.assert_allclose(energies, energy, atol=1e-12)


@pytest.mark.parametrize("kernel", ["rbf", "linear"])
@pytest.mark.parametrize("normalize", [True, False])
def test_a_model_without_its_gram_matrix_scores_the_same(kernel, normalize):
    rng = np.random.default_rng(6)
    X, y, queries = rng.normal(size=(90, 6)), np.arange(90) % 4, rng.normal(size=(30, 6))
    X[5] = 0
    model = KSC(kernel, normalize_kernel=normalize).fit(X, y)
    lean = KSC(kernel, normalize_kernel=normalize, store_gram=False).fit(X, y)
    np.testing.assert_allclose(lean.decision_function(queries), model.decision_function(queries), atol=1e-10)
    assert lean._gram.stored.size == 0


def test_a_gram_matrix_is_not_stored_beyond_its_limit(monkeypatch):
    monkeypatch.setattr("fusion.sparse_coding.STORED_BYTES", 8 * 50**2)
    X = np.random.default_rng(7).normal(size=(60, 3))
    assert KSC().fit(X[:50], np.arange(50) % 2)._gram.stored.shape == (1, 50, 50)
    assert KSC().fit(X, np.arange(60) % 2)._gram.stored.size == 0
    assert KSC(solver="lasso").fit(X, np.arange(60) % 2)._gram.stored.size == 3600


@pytest.mark.parametrize("setting", [{"kernel": "precomputed"}, {"solver": "lasso"}])
def test_rows_on_demand_are_refused_where_they_cannot_be_had(setting):
    with pytest.raises(ValueError, match="store_gram=False needs"):
        KSC(**setting, store_gram=False).fit(np.eye(4), [0, 1, 0, 1])
    with pytest.raises(ValueError, match="store_gram must be"):
        KSC(**setting, store_gram="never").fit(np.eye(4), [0, 1, 0, 1])


def test_scratch_of_another_tile_size_is_refused():
    gram, kernels = stored_gram([np.eye(5)]), frozen(np.ones((1, 1, 5)))
    codes = np.full((1, 2), -1), np.zeros((1, 1, 2)), np.zeros((1, 1))
    with pytest.raises(ValueError, match="whole tiles"):
        pursue(gram, kernels, np.ones((1, 5)), np.zeros(2), 0, 1, np.empty((1, 2, 5)), np.empty((3, 5)), *codes)


@pytest.mark.slow
def test_compiles_where_no_folder_can_be_written(tmp_path):
    package = tmp_path / "fusion"
    package.mkdir()
    for source in Path(fusion.__file__).parent.glob("*.py"):
        (package / source.name).write_bytes(source.read_bytes())
    code = (
        "import numba.core.caching as c\n"
        "for locator in c.CacheImpl._locator_classes: locator.from_function = classmethod(lambda *a: None)\n"
        "import numpy as np, fusion\n"
        "print(fusion.__file__, fusion.kernel_omp_gram(np.eye(3), np.eye(3), 2)[0].tolist())"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(tmp_path)}, text=True,
        capture_output=True, check=True,
    )  # fmt: skip
    assert str(package) in answer.stdout
    assert answer.stdout.endswith("[[0, -1], [1, -1], [2, -1]]\n")
