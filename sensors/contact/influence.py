"""Influence coefficients between chosen cells, read from a table that is made once per compliance.

Both compliances are filters, so a coefficient depends on the cells' distance, and between mirrors on their sum as well.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sensors.compiled import compiled

Cells = NDArray[np.intp]


def sine_table(symbol: NDArray[np.float64]) -> NDArray[np.float64]:
    """Table (2n + 1, 2n + 1) of `mirrored` for a symbol (n, n) that is diagonal in the sines of an n x n grid.

    sin a sin b = (cos(a - b) - cos(a + b)) / 2 along both axes, with the normalisation of `sine_basis`.
    """
    n = symbol.shape[0]
    weight = np.full(n, 1 / n)
    weight[-1] /= 2
    cosine = np.cos(np.pi / n * np.outer(np.arange(2 * n + 1), np.arange(1, n + 1))) * weight
    table: NDArray[np.float64] = cosine @ symbol @ cosine.T
    return table


@compiled
def mirrored(table: NDArray[np.float64], rows: Cells, columns: Cells) -> NDArray[np.float64]:
    """Coefficients (cells, cells) of a `sine_table`: an edge that cannot move mirrors every load with a minus sign."""
    count = rows.size
    matrix = np.empty((count, count))
    for i in range(count):
        for j in range(i + 1):
            down, down_sum = abs(rows[i] - rows[j]), rows[i] + rows[j] + 1
            across, across_sum = abs(columns[i] - columns[j]), columns[i] + columns[j] + 1
            value = table[down, across] - table[down_sum, across] - table[down, across_sum]
            value += table[down_sum, across_sum]
            matrix[i, j] = value
            matrix[j, i] = value
    return matrix


@compiled
def translated(table: NDArray[np.float64], rows: Cells, columns: Cells) -> NDArray[np.float64]:
    """Coefficients (cells, cells) of a `table` (n, n) over the cells' distances along both axes: no edge is felt."""
    count = rows.size
    matrix = np.empty((count, count))
    for i in range(count):
        for j in range(i + 1):
            value = table[abs(rows[i] - rows[j]), abs(columns[i] - columns[j])]
            matrix[i, j] = value
            matrix[j, i] = value
    return matrix
