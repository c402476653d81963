"""Reading a matrix of taxels row by row: what each way to treat the rows that are not read does to the voltages.

Row r is at the supply V; every column has a divider resistor to ground (conductance g). The other rows are

    isolated       cut off taxel by taxel:      U_rc = V G_rc / (g + G_rc)                  no crosstalk
    grounded_rows  held at 0 V:                 U_rc = V G_rc / (g + S_c), S_c = sum_i G_ic  exactly correctable
    floating       open: current comes round through the other taxels, a linear network      ghosts

Summed over the rows, a grounded column gives sum_r U_rc = V S_c / (g + S_c), hence S_c and every G_rc in closed form.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Scanning = Literal["isolated", "grounded_rows", "floating"]


def scan(conductance: Array, divider_ohm: float, supply_v: float, scanning: Scanning) -> Array:
    """Column voltages (T, rows, columns; V) while each row is read, for conductances of that shape (S)."""
    sense = 1 / divider_ohm
    if scanning == "isolated":
        return supply_v * conductance / (sense + conductance)
    if scanning == "grounded_rows":
        return supply_v * conductance / (sense + conductance.sum(axis=1, keepdims=True))
    if scanning != "floating":
        raise ValueError(f"unknown scanning {scanning!r}; known: isolated, grounded_rows, floating")
    return np.stack([_float_row(conductance, row, sense, supply_v) for row in range(conductance.shape[1])], axis=1)


def _float_row(conductance: Array, row: int, sense: float, supply_v: float) -> Array:
    """Column voltages (T, columns) while `row` is driven and the others float; their nodes are eliminated first."""
    others = np.delete(conductance, row, axis=1)
    total = others.sum(axis=2, keepdims=True)
    share = np.divide(others, total, out=np.zeros_like(others), where=total > 0)
    column = sense + conductance.sum(axis=1)
    system = column[:, :, None] * np.eye(conductance.shape[2]) - np.swapaxes(others, 1, 2) @ share
    driven = supply_v * conductance[:, row]
    return np.asarray(np.linalg.solve(system, driven[..., None])[..., 0])


def correct_grounded_rows(voltage: Array, divider_ohm: float, supply_v: float) -> Array:
    """Conductances (T, rows, columns; S) from the voltages (V) of a `grounded_rows` scan of all rows; exact.

    Voltages of a column that sum to the supply or more (noise at saturation) count as just below it.
    """
    together = np.minimum(voltage.sum(axis=1, keepdims=True) / supply_v, 1 - 1e-6)
    return np.asarray(voltage / supply_v / (1 - together) / divider_ohm)
