"""From sparse codes to class scores: how well the atoms of one class alone rebuild a query."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.komp import FloatArray, IntArray

MASK_STEP = 1.0


def class_residual(
    grams: Sequence[FloatArray],
    kernels: Sequence[FloatArray],
    indices: IntArray,
    coefs: FloatArray,
    atom_class: IntArray,
    n_classes: int,
    weights: Sequence[float],
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Residual of each query in each class and which classes hold a selected atom: both (q, n_classes).

    r_c = sum_m w_m (-2 kappa_m(s, D_c) x_mc + x_mc' kappa_m(D_c, D_c) x_mc), as in the FVSight paper, eq. 4
    and 6. The query's own kappa(s, s) is the same for every class and stays out: added, it swallows the
    others where a narrow kernel makes them small. `indices` is (q, k), -1 in unused places, `coefs`
    (M, q, k).
    """
    n_queries, width = indices.shape
    rows = np.arange(n_queries)
    filled = indices >= 0
    atoms = np.where(filled, indices, 0)
    place_class = atom_class[atoms]
    residual = np.zeros((n_queries, n_classes))
    has_atom = np.zeros((n_queries, n_classes), dtype=bool)
    for place in range(width):
        mine = place_class[:, place]
        has_atom[rows, mine] |= filled[:, place]
        for gram, kernel, x, weight in zip(grams, kernels, coefs, weights, strict=True):
            inner = -2.0 * kernel[rows, atoms[:, place]]
            for other in range(width):
                same = np.where(place_class[:, other] == mine, x[:, other], 0.0)
                inner += same * gram[atoms[:, place], atoms[:, other]]
            residual[rows, mine] += weight * x[:, place] * inner
    return residual, has_atom


def class_scores(residual: FloatArray, has_atom: NDArray[np.bool_]) -> FloatArray:
    """Minus the residual; a class without a selected atom scores finitely below every class that has one.

    A query without any selected atom (a zero query) scores 0 in every class. Both arrays are (q, n_classes).
    """
    scores = np.where(has_atom, -residual, 0.0)
    span = np.max(np.abs(scores), axis=1, keepdims=True)
    lowest = np.min(np.where(has_atom, scores, np.inf), axis=1, keepdims=True)
    floor = np.where(np.isfinite(lowest), lowest, MASK_STEP + span) - (MASK_STEP + span)
    return np.where(has_atom, scores, floor)
