"""What linear elasticity leaves out of a bonded film, by the depth that it is pressed to: out of the ladder's table."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from sensors.contact.ladder.choose import choose_rung
from sensors.contact.ladder.indenters import INDENTER_CLASSES
from sensors.contact.ladder.interface import Pad
from sensors.contact.ladder.table import LadderTable, committed_table
from sensors.contact.layer import LayerMaterial

_RUNG, _SIDE = "layer-fine", 8.0
"""The finest linear layer on the pad where its cells are smallest: what is left is the linear model."""


@dataclass(frozen=True)
class LinearError:
    """Largest relative errors of the linear film over the classes of indenter, up to `depth_ratio` (d/h, measured)."""

    force: float
    displacement: float
    depth_ratio: float


def linear_error(depth_ratio: float, poisson_ratio: float) -> LinearError:
    """Force and displacement error of a linear film pressed to `depth_ratio` > 0, against the hyperelastic one.

    The worst of the ladder's classes, which stand for whatever presses, up to the first measured depth that is not less
    than `depth_ratio`; what the reference itself still moves is counted. ValueError deeper than measured, or for a
    Poisson's ratio outside those measured.
    """
    depths = _linear_rows().depth_ratios
    if not depth_ratio <= depths[-1]:
        raise ValueError(
            f"the film is pressed to {depth_ratio:.2f} of its thickness, deeper than measured ({depths[-1]:g}): the "
            "error of its linear model is unknown"
        )
    return _worst(next(depth for depth in depths if depth >= depth_ratio), poisson_ratio)


@lru_cache(maxsize=64)
def _worst(depth_ratio: float, poisson_ratio: float) -> LinearError:
    pad, free = Pad(LayerMaterial(1.0, 1.0, poisson_ratio), _SIDE), math.inf
    found = [
        choose_rung(pad, name, free, free, depth_ratio=depth_ratio, table=_linear_rows()) for name in INDENTER_CLASSES
    ]
    force, displacement = (max(getattr(one, f"{name}_error") for one in found) for name in ("force", "displacement"))
    return LinearError(force, displacement, depth_ratio)


@lru_cache(maxsize=1)
def _linear_rows() -> LadderTable:
    table = committed_table()
    return replace(table, rows=tuple(row for row in table.rows if (row.rung, row.side_ratio) == (_RUNG, _SIDE)))
