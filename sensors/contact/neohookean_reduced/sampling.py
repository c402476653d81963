"""Energy-conserving sampling and weighting (ECSW): a few elements whose weighted forces stand for those of all.

Weights are never negative, so that the reduced stiffness keeps the sign of the full one. Source: C. Farhat, P. Avery,
T. Chapman, J. Cortial, Int. J. Numer. Meth. Eng. 98 (2014); compressed to leading singular vectors as in
J. A. Hernandez et al., CMAME 313 (2017).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

Floats = NDArray[np.float64]


def sample_elements(contributions: Floats, tolerance: float) -> Floats:
    """Weights (elements,) >= 0, most of them zero, so that contributions @ weights is near contributions @ 1.

    Each row of `contributions` (rows, elements) is one generalised force of one snapshot. What of them is not spanned
    by the leading singular vectors is at most `tolerance` of their norm; the total weight is kept too. At `tolerance`
    zero every element is kept with weight one.
    """
    count = contributions.shape[1]
    if tolerance <= 0:
        return np.ones(count)
    _, values, rows = np.linalg.svd(contributions, full_matrices=False)
    lost = np.sqrt(np.cumsum(values[::-1] ** 2)[::-1])
    kept = max(1, int((lost > tolerance * lost[0]).sum()))
    matrix = np.vstack([values[:kept, None] * rows[:kept] / values[0], np.full(count, 1 / np.sqrt(count))])
    weights, _ = nnls(matrix, matrix.sum(axis=1), maxiter=30 * count)
    return np.asarray(weights, np.float64)
