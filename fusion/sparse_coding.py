"""Kernel sparse coding and joint kernel sparse coding as scikit-learn classifiers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from fusion.arrays import FloatArray
from fusion.class_residual import class_residual, class_scores
from fusion.coordinate_descent import check_penalty, gram_lasso
from fusion.gram import Gram
from fusion.kernels import KERNELS, Gamma
from fusion.komp import PivotTol, SparseCodes, joint_komp, pivot_tolerances
from fusion.modality import (
    COMPUTABLE,
    KernelName,
    Modality,
    dictionary,
    kernel_rows,
    modality_columns,
    modality_weights,
)
from fusion.seen import seen_columns_only
from fusion.settings import check_jobs, check_known, not_negative, whole_number
from fusion.threads import map_threads

BLOCK_BYTES = 2**22  # of kernel rows that a thread takes at once
STORED_BYTES = 2**30  # of Gram matrices that store_gram="auto" keeps
WHOLE = "all"


class KSC(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """Classify by kernel sparse coding over all training samples.

    A query is coded over the training samples (the atoms) in the kernel's feature space with few non-zeros;
    the class whose own atoms rebuild it best wins.

    Parameters
    ----------
    kernel : "rbf", "linear", "precomputed" (then X is (n, n) at fit and (q, n) later), or a function of two
        sets of rows (q, d) and (n, d) that returns (q, n), such as `fusion.GlobalAlignment`.
    gamma : RBF width; "scale" is 1 / (columns x variance), a number is used as it is.
    n_nonzero_coefs : most atoms in one code (solver "komp").
    solver : "komp", kernel orthogonal matching pursuit, or "lasso", coordinate descent on the l1 form.
    penalty : l1 weight as a part of the smallest weight at which the code is empty (solver "lasso").
    normalize_kernel : divide k(x, y) by sqrt(k(x, x) k(y, y)); changes nothing for "rbf". With "precomputed"
        only the atoms' side can be known; a query's scores then carry its own positive factor. A kernel
        function is called once more for each row: say False where its own values are 1 already.
    store_gram : keep the atoms' Gram matrix (n, n), or compute the rows that a code needs from the atoms, to
        rounding the same and slower ("rbf" and "linear" with solver "komp"); "auto" keeps up to 1 GiB.
    pivot_tol : see `fusion.kernel_omp_gram`.
    max_sweeps, tol : limits of the solver "lasso".
    n_jobs : threads over blocks of queries; results do not depend on it.

    Attributes
    ----------
    classes_ : (n_classes,) labels in order.
    n_features_in_ : columns of X.

    Scores are comparable within one query, not between queries: RBF rows are divided by the kernel value of
    the query's closest atom, which changes no label and leaves nothing to underflow in narrow kernels. A
    query for which no atom can be chosen (a zero row under "linear") scores 0 everywhere: the first class.

    References
    ----------
    Li, Gao, Sun, "Kernel sparse representation based classification", Neurocomputing, 2011.
    """

    def __init__(
        self,
        kernel: KernelName = "rbf",
        *,
        gamma: Gamma = "scale",
        n_nonzero_coefs: int = 10,
        solver: Literal["komp", "lasso"] = "komp",
        penalty: float = 0.1,
        normalize_kernel: bool = True,
        store_gram: bool | Literal["auto"] = "auto",
        pivot_tol: PivotTol = "auto",
        max_sweeps: int = 200,
        tol: float = 1e-4,
        n_jobs: int | None = None,
    ) -> None:
        self.kernel = kernel
        self.gamma = gamma
        self.n_nonzero_coefs = n_nonzero_coefs
        self.solver = solver
        self.penalty = penalty
        self.normalize_kernel = normalize_kernel
        self.store_gram = store_gram
        self.pivot_tol = pivot_tol
        self.max_sweeps = max_sweeps
        self.tol = tol
        self.n_jobs = n_jobs

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Keep the rows of X (n, d) as atoms with the labels y (n,)."""
        data, labels = validate_data(self, X, y, dtype=np.float64)
        if labels.dtype.kind not in "biu":  # whole numbers are classes; finding that out costs as much as the fit
            check_classification_targets(labels)
        self._check_parameters()
        self.classes_, self._atom_class = np.unique(labels, return_inverse=True)
        self._columns = self._modality_columns(data.shape[1])
        self._modalities = {
            name: Modality.fit(data[:, columns], self.kernel, self._modality_gamma(name), self.normalize_kernel)
            for name, columns in self._columns.items()
        }
        self._gram = dictionary(list(self._modalities.values()), self._stores_gram(len(data)))
        return self

    def decision_function(self, X: ArrayLike) -> FloatArray:
        """Minus the class residual: (q, n_classes), or (q,) second minus first class where there are two."""
        return self._decision(X, self._fitted_weights())

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Label of each row of X (q, d); ties go to the first class."""
        return self._predict(X, self._fitted_weights())

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.input_tags.pairwise = self.kernel == "precomputed"
        return tags

    def _check_parameters(self) -> None:
        if not callable(self.kernel) and self.kernel not in KERNELS:
            raise ValueError(f"kernel must be one of {', '.join(KERNELS)}, or a function; got {self.kernel!r}.")
        if self.solver not in ("komp", "lasso"):
            raise ValueError(f"solver must be one of komp, lasso; got {self.solver!r}.")
        if not isinstance(self.normalize_kernel, (bool, np.bool_)):
            raise ValueError(f"normalize_kernel must be True or False, got {self.normalize_kernel!r}.")
        whole_number("n_nonzero_coefs", self.n_nonzero_coefs, 1)
        pivot_tolerances(self.pivot_tol, 1)
        check_penalty(self.penalty)
        whole_number("max_sweeps", self.max_sweeps, 1)
        not_negative("tol", self.tol)
        check_jobs(self.n_jobs)

    def _modality_columns(self, n_features: int) -> dict[str, Any]:
        return {WHOLE: slice(0, n_features)}

    def _modality_gamma(self, name: str) -> object:
        return self.gamma

    def _fitted_weights(self) -> dict[str, float]:
        return {WHOLE: 1.0}

    def _predict(self, X: ArrayLike, weights: Mapping[str, float]) -> NDArray[Any]:
        decision = self._decision(X, weights)
        winner = (decision > 0).astype(int) if decision.ndim == 1 else np.argmax(decision, axis=1)
        return np.asarray(self.classes_[winner])

    def _stores_gram(self, n_atoms: int) -> bool:
        if self.store_gram not in (True, False, "auto"):
            raise ValueError(f"store_gram must be True, False or 'auto', got {self.store_gram!r}.")
        possible = self.kernel in COMPUTABLE and self.solver == "komp"
        if self.store_gram is False and not possible:
            raise ValueError("store_gram=False needs kernel 'rbf' or 'linear' and solver 'komp'.")
        if self.store_gram != "auto":
            return bool(self.store_gram)
        return not possible or 8 * len(self._modalities) * n_atoms**2 <= STORED_BYTES

    def _decision(self, X: ArrayLike, weights: Mapping[str, float]) -> FloatArray:
        check_is_fitted(self)
        used = {name: weight for name, weight in weights.items() if weight > 0}
        data = seen_columns_only(self, X, self._columns, used)
        places = [place for place, name in enumerate(self._modalities) if name in used]
        used = {name: used[name] for name in self._modalities if name in used}
        groups = [(members, self._gram.part([places[i] for i in members])) for members in self._coupled(len(used))]
        scores = np.empty((len(data), len(self.classes_)))

        def work(start: int) -> None:
            rows = slice(start, start + block)
            scores[rows] = self._score_block(data[rows], used, groups)

        block = max(1, BLOCK_BYTES // (8 * len(used) * len(self._atom_class)))
        map_threads(work, range(0, len(data), block), self.n_jobs)
        return scores[:, 1] - scores[:, 0] if len(self.classes_) == 2 else scores

    def _score_block(
        self, data: FloatArray, weights: Mapping[str, float], groups: list[tuple[list[int], Gram]]
    ) -> FloatArray:
        kernels = kernel_rows(
            [self._modalities[name] for name in weights], [data[:, self._columns[name]] for name in weights]
        )
        values = list(weights.values())
        residual = np.zeros((len(data), len(self.classes_)))
        has_atom = np.zeros(residual.shape, dtype=bool)
        for members, gram in groups:
            k = kernels[members[0] : members[-1] + 1]
            w = [values[i] for i in members]
            codes = self._encode(gram, k, w)
            part, chosen = class_residual(gram, k, codes.indices, codes.coefs, self._atom_class, len(self.classes_), w)
            residual += part
            has_atom |= chosen
        return class_scores(residual, has_atom)

    def _coupled(self, n_modalities: int) -> list[list[int]]:
        return [list(range(n_modalities))]

    def _encode(self, gram: Gram, kernels: FloatArray, weights: list[float]) -> SparseCodes:
        if self.solver == "lasso":
            return gram_lasso(gram, kernels, self.penalty, weights=weights, max_sweeps=self.max_sweeps, tol=self.tol)
        codes, _ = joint_komp(gram, kernels, self.n_nonzero_coefs, weights=weights, pivot_tol=self.pivot_tol)
        return codes


class JKSC(KSC):
    """Classify by joint kernel sparse coding: a kernel per modality, class residuals summed over modalities.

    Parameters
    ----------
    modalities : name -> columns of X (a slice or an array of column numbers), or None for one modality of all
        columns, which gives KSC to the bit.
    coupling : "shared", one support for all modalities (Liu, Guo, Sun 2016), or "independent", a code of its
        own per modality (the FVSight paper, eq. 6).
    weights : name -> weight of a modality's residual and, when shared, of its say in the choice of atoms;
        modalities not named weigh 1. Weight 0 leaves a modality out, as for a sensor that is missing.
    gamma : as in KSC ("scale" per modality), or name -> either.
    Other parameters : as in KSC. `kernel="precomputed"` allows one modality only.

    The RBF shift is common to the modalities (the smallest exponent over all of them), so that it multiplies
    every residual of a query by one factor.

    References
    ----------
    Liu, Guo, Sun, "Object recognition using tactile measurements: kernel sparse coding methods", IEEE TIM
    65(3), 2016. "A novel tactile sensor with multimodal vision and tactile units for multifunctional robot
    interaction" (the FVSight paper), section 4.2.
    """

    def __init__(
        self,
        modalities: Mapping[str, Any] | None = None,
        *,
        coupling: Literal["shared", "independent"] = "shared",
        weights: Mapping[str, float] | None = None,
        kernel: KernelName = "rbf",
        gamma: Gamma | Mapping[str, Gamma] = "scale",
        n_nonzero_coefs: int = 10,
        solver: Literal["komp", "lasso"] = "komp",
        penalty: float = 0.1,
        normalize_kernel: bool = True,
        store_gram: bool | Literal["auto"] = "auto",
        pivot_tol: PivotTol = "auto",
        max_sweeps: int = 200,
        tol: float = 1e-4,
        n_jobs: int | None = None,
    ) -> None:
        self.modalities = modalities
        self.coupling = coupling
        self.weights = weights
        self.kernel = kernel
        self.gamma = gamma  # type: ignore[assignment]
        self.n_nonzero_coefs = n_nonzero_coefs
        self.solver = solver
        self.penalty = penalty
        self.normalize_kernel = normalize_kernel
        self.store_gram = store_gram
        self.pivot_tol = pivot_tol
        self.max_sweeps = max_sweeps
        self.tol = tol
        self.n_jobs = n_jobs

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Keep the rows of X (n, d), cut into modalities, as atoms with the labels y (n,)."""
        if self.coupling not in ("shared", "independent"):
            raise ValueError(f"coupling must be 'shared' or 'independent', got {self.coupling!r}.")
        if self.kernel == "precomputed" and self.modalities is not None:
            raise ValueError("kernel='precomputed' holds one kernel: leave modalities=None.")
        super().fit(X, y)
        self._weights = modality_weights(self.weights, list(self._columns))
        return self

    def decision_function(self, X: ArrayLike, *, weights: Mapping[str, float] | None = None) -> FloatArray:
        """Minus the summed class residuals, as in KSC; `weights` as in `predict`."""
        return self._decision(X, self._call_weights(weights))

    def predict(self, X: ArrayLike, *, weights: Mapping[str, float] | None = None) -> NDArray[Any]:
        """Label of each row of X (q, d); `weights` takes the place of the fitted ones for the modalities it names.

        A modality that is missing gets weight 0, {"force": 0}: its columns are not looked at and may hold anything,
        NaN and infinity too.
        """
        return self._predict(X, self._call_weights(weights))

    def _call_weights(self, weights: Mapping[str, float] | None) -> dict[str, float]:
        check_is_fitted(self)
        return self._weights if weights is None else modality_weights(weights, list(self._columns), self._weights)

    def _modality_columns(self, n_features: int) -> dict[str, Any]:
        given = self.modalities
        columns = super()._modality_columns(n_features) if given is None else modality_columns(given, n_features)
        if isinstance(self.gamma, Mapping):
            check_known("gamma names", self.gamma, columns)
        return columns

    def _modality_gamma(self, name: str) -> object:
        return self.gamma.get(name, "scale") if isinstance(self.gamma, Mapping) else self.gamma

    def _coupled(self, n_modalities: int) -> list[list[int]]:
        if self.coupling == "shared":
            return super()._coupled(n_modalities)
        return [[i] for i in range(n_modalities)]
