"""What a chain is given: loads and gains that a taxel can have."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def finite_load(load: NDArray[np.floating], gain: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """The loads (T, taxels; N) in double precision.

    Raises ValueError for a load or gain that is not finite, and for a gain below 0.
    """
    loads = np.asarray(load, dtype=np.float64)
    if not np.isfinite(loads).all():
        raise ValueError("expected finite taxel loads in newtons, got NaN or infinity")
    gains = np.asarray(gain)
    if not ((gains >= 0) & (gains < np.inf)).all():
        raise ValueError("expected a finite gain >= 0 of every taxel, got one below 0, NaN or infinity")
    return loads
