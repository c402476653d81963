"""From sparse codes to class scores: how well the atoms of one class alone rebuild a query."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.arrays import FloatArray, IntArray, frozen
from fusion.compiled import compiled
from fusion.gram import Gram
from fusion.pairs import gram_value

MASK_STEP = 1.0


def class_residual(
    gram: Gram,
    kernels: FloatArray,
    indices: IntArray,
    coefs: FloatArray,
    atom_class: IntArray,
    n_classes: int,
    weights: Sequence[float],
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Residual of each query in each class and which classes hold a selected atom: both (q, n_classes).

    r_c = sum_m w_m (-2 kappa_m(s, D_c) x_mc + x_mc' kappa_m(D_c, D_c) x_mc), as in the FVSight paper, eq. 4
    and 6. The query's own kappa(s, s) is the same for every class and stays out: added, it swallows the
    others where a narrow kernel makes them small. `kernels` is (M, q, n), `indices` (q, k), -1 in unused
    places, `coefs` (M, q, k).
    """
    residual = np.zeros((len(indices), n_classes))
    has_atom = np.zeros((len(indices), n_classes), dtype=np.bool_)
    _add_residuals(
        gram,
        frozen(kernels),
        frozen(indices, np.int64),
        frozen(coefs),
        frozen(atom_class, np.int64),
        np.array(weights, dtype=np.float64),
        residual,
        has_atom,
    )
    return residual, has_atom


@compiled
def _add_residuals(
    gram: Gram,
    kernels: FloatArray,
    indices: IntArray,
    coefs: FloatArray,
    atom_class: IntArray,
    weights: FloatArray,
    residual: FloatArray,
    has_atom: NDArray[np.bool_],
) -> None:
    n_queries, width = indices.shape
    stored = len(gram.stored) > 0
    classes = np.empty(width, dtype=np.int64)
    for q in range(n_queries):
        for place in range(width):
            atom = indices[q, place]
            classes[place] = atom_class[atom] if atom >= 0 else -1
        for place in range(width):
            atom, mine = indices[q, place], classes[place]
            if atom < 0:
                continue
            has_atom[q, mine] = True
            for m in range(len(weights)):
                inner = -2.0 * kernels[m, q, atom]
                for other in range(width):
                    if classes[other] == mine:
                        partner = indices[q, other]
                        value = gram.stored[m, atom, partner] if stored else gram_value(gram, m, atom, partner)
                        inner += coefs[m, q, other] * value
                residual[q, mine] += weights[m] * coefs[m, q, place] * inner


def class_scores(residual: FloatArray, has_atom: NDArray[np.bool_]) -> FloatArray:
    """Minus the residual; a class without a selected atom scores finitely below every class that has one.

    A query without any selected atom (a zero query) scores 0 in every class. Both arrays are (q, n_classes).
    """
    scores = np.empty(residual.shape)
    _write_scores(residual, has_atom, scores)
    return scores


@compiled
def _write_scores(residual: FloatArray, has_atom: NDArray[np.bool_], scores: FloatArray) -> None:
    n_queries, n_classes = residual.shape
    for q in range(n_queries):
        span, lowest = 0.0, math.inf
        for c in range(n_classes):
            if has_atom[q, c]:
                score = -residual[q, c]
                scores[q, c] = score
                if not (abs(score) <= span or math.isnan(span)):  # NaN stays
                    span = abs(score)
                lowest = min(lowest, score)
        missing = (lowest if math.isfinite(lowest) else MASK_STEP + span) - (MASK_STEP + span)
        for c in range(n_classes):
            if not has_atom[q, c]:
                scores[q, c] = missing
