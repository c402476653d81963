"""Compiled loops over pairs of rows: each value from its own pair alone, summed in the order of the columns.

Rows of the second side lie in columns, so that the loops run over many pairs at once and still add up each
pair's terms one after the other.
"""

from __future__ import annotations

import math

from fusion.arrays import FloatArray
from fusion.compiled import compiled, unsigned
from fusion.gram import Gram

BLOCK_BYTES = 2**18  # of the second side: what stays near a core while all queries pass


@compiled
def pair_sums(queries: FloatArray, columns: FloatArray, squared: bool, out: FloatArray) -> None:
    """Write the squared distances (squared) or inner products of `queries` (q, d) and `columns` (d, n): (q, n)."""
    d, n = columns.shape
    block = max(64, BLOCK_BYTES // (8 * d))
    for start in range(0, n, block):
        begin, end = unsigned(start), unsigned(min(start + block, n))
        for q in range(len(queries)):
            for p in range(begin, end):
                out[q, p] = 0.0
            for c in range(d):
                x = queries[q, c]
                if squared:
                    for p in range(begin, end):
                        step = x - columns[c, p]
                        out[q, p] += step * step
                else:
                    for p in range(begin, end):
                        out[q, p] += x * columns[c, p]


@compiled
def gram_row(gram: Gram, m: int, atom: int, out: FloatArray) -> None:
    """Write the Gram row of `atom` in modality `m`, computed from the atoms, into `out` (n,)."""
    n = unsigned(gram.atoms.shape[1])
    width = gram.widths[m]
    for p in range(unsigned(0), n):
        out[p] = 0.0
    for c in range(gram.bounds[m], gram.bounds[m + 1]):
        x = gram.atoms[c, atom]
        if width >= 0.0:
            for p in range(unsigned(0), n):
                step = x - gram.atoms[c, p]
                out[p] += step * step
        else:
            for p in range(unsigned(0), n):
                out[p] += x * gram.atoms[c, p]
    own = gram.factors[m, atom]
    for p in range(unsigned(0), n):
        value = math.exp(-width * out[p]) if width >= 0.0 else out[p]
        out[p] = value * own * gram.factors[m, p]
    out[atom] = gram.diagonals[m, atom]


@compiled
def gram_value(gram: Gram, m: int, i: int, j: int) -> float:
    """Gram value of the atoms `i` and `j` in modality `m`, stored or computed."""
    if len(gram.stored):
        return gram.stored[m, i, j]
    if i == j:
        return gram.diagonals[m, i]
    width = gram.widths[m]
    total = 0.0
    for c in range(gram.bounds[m], gram.bounds[m + 1]):
        x, y = gram.atoms[c, i], gram.atoms[c, j]
        total += (x - y) * (x - y) if width >= 0.0 else x * y
    if width >= 0.0:
        total = math.exp(-width * total)
    return total * gram.factors[m, i] * gram.factors[m, j]
