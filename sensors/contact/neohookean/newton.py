"""Newton's method for a minimum, with a sparse direct solver and a line search on the energy."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.typing import NDArray

from sensors.contact.solver import ConvergenceError

Floats = NDArray[np.float64]

_ARMIJO = 1e-4
_ROUNDING = 1e-13
"""Relative change of the energy that counts as none."""

_CLOSE = 1e-4
"""Fall of the energy, relative to it, below which the gradient is the better guide."""

_CONCAVE = 0.9
"""Fall of the energy over that of its slope from which on it bends downwards: a parabola's minimum gives one half."""

_HALVINGS = 14
_SHIFTS = (0.0, 1e-4, 1e-2, 1.0)
"""Multiples of the diagonal added to a tangent that gives no direction of descent."""


class Potential(Protocol):
    """A function of a vector, with its derivatives."""

    def energy(self, at: Floats) -> float:
        """Value, infinite outside the domain."""
        ...

    def gradient(self, at: Floats) -> Floats:
        """First derivative, of the shape of `at`."""
        ...

    def hessian(self, at: Floats) -> sp.csc_matrix:
        """Second derivative; rows in an order that factorises well."""
        ...


@dataclass(frozen=True)
class Minimum:
    """Where Newton ended, in how many iterations, and the norm of the gradient there."""

    at: Floats
    iterations: int
    residual: float


def minimise(potential: Potential, start: Floats, tolerance: float, largest_step: float, limit: int = 40) -> Minimum:
    """Newton from `start` until the gradient's norm is below `tolerance`.

    No component moves by more than `largest_step` in one iteration. Raises ConvergenceError when the line search finds
    no lower energy or after `limit` iterations.
    """
    at, gradient = start, potential.gradient(start)
    value = potential.energy(start)
    for iteration in range(limit + 1):
        residual = float(np.linalg.norm(gradient))
        if residual <= tolerance:
            return Minimum(at, iteration, residual)
        if iteration == limit:
            break
        direction = _descent(potential.hessian(at), gradient)
        longest = largest_step / float(np.abs(direction).max())
        slope = float(gradient @ direction)
        found = _close_in(potential, at, value, direction, slope, longest, residual)
        found = found or _line_search(potential, at, value, direction, slope, longest)
        if found is None:
            break
        at, value = found
        gradient = potential.gradient(at)
    raise ConvergenceError(
        f"Newton stopped at iteration {iteration} with residual {residual:.2e} N > {tolerance:.2e} N; "
        "press less deep, in smaller steps, or on a finer mesh"
    )


def _descent(hessian: sp.csc_matrix, gradient: Floats) -> Floats:
    """Newton's direction, shifted towards steepest descent where the tangent is not positive along it."""
    diagonal = np.abs(hessian.diagonal())
    for shift in _SHIFTS:
        shifted = hessian if shift == 0 else hessian + sp.diags(shift * diagonal, format="csc")
        direction = _solve(shifted, -gradient)
        if direction is not None and gradient @ direction < 0:
            return direction
    return -gradient / np.maximum(diagonal, diagonal.max() * 1e-12)


def _solve(matrix: sp.csc_matrix, right: Floats) -> Floats | None:
    """One symmetric solve in the given order; None where the matrix is singular."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            factors = spla.splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except (RuntimeError, Warning):
        return None
    out: Floats = factors.solve(right)
    return out if np.isfinite(out).all() else None


def _close_in(
    potential: Potential, at: Floats, value: float, direction: Floats, slope: float, longest: float, residual: float
) -> tuple[Floats, float] | None:
    """The full step where little energy is left to lose and the gradient halves: there energies only round."""
    if abs(slope) > _CLOSE * abs(value) or longest < 1:
        return None
    energy = potential.energy(at + direction)
    if np.isfinite(energy) and np.linalg.norm(potential.gradient(at + direction)) < residual / 2:
        return at + direction, energy
    return None


def _line_search(
    potential: Potential, at: Floats, value: float, direction: Floats, slope: float, longest: float
) -> tuple[Floats, float] | None:
    """A point along `direction` with enough less energy: shorter steps where it rises, longer where it bends down."""
    slack = _ROUNDING * abs(value)
    step = min(1.0, longest)
    for _ in range(_HALVINGS):
        energy = potential.energy(at + step * direction)
        if energy <= value + _ARMIJO * step * slope + slack:
            break
        step /= 2
    else:
        return None
    while energy < value + _CONCAVE * step * slope - slack and 2 * step <= longest:
        longer = potential.energy(at + 2 * step * direction)
        if longer >= energy:
            break
        step, energy = 2 * step, longer
    return at + step * direction, energy
