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

_CHORD = 0.2
_NEWTON = 0.5
"""What the gradient must fall to, under an old tangent and under its own, for a step to be taken without the energy."""

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


class Factors(Protocol):
    """A factorised tangent."""

    def solve(self, right: Floats) -> Floats:
        """The solution of tangent x = right."""
        ...


@dataclass(frozen=True)
class Minimum:
    """Where Newton ended, with how many tangents, the norm of the gradient there, and the last tangent's factors."""

    at: Floats
    iterations: int
    residual: float
    factors: Factors | None


def minimise(
    potential: Potential,
    start: Floats,
    tolerance: float,
    largest_step: float,
    *,
    factors: Factors | None = None,
    limit: int = 40,
) -> Minimum:
    """Newton from `start` until the gradient's norm is below `tolerance`.

    No component moves by more than `largest_step` in one iteration. The last tangent, or `factors` of one nearby, is
    used again as long as that cuts the gradient to a fifth: its factors are nine tenths of the cost. Raises
    ConvergenceError when the line search finds no lower energy or after `limit` tangents.
    """
    at, gradient = start, potential.gradient(start)
    value, tangents = potential.energy(start), 0
    while (residual := float(np.linalg.norm(gradient))) > tolerance and tangents < limit:
        found = None
        if factors is not None:
            direction = factors.solve(-gradient)
            found = _close_in(potential, at, value, gradient, direction, largest_step, _CHORD * residual)
        if found is None:
            direction, factors = _descent(potential.hessian(at), gradient)
            tangents += 1
            found = _close_in(potential, at, value, gradient, direction, largest_step, _NEWTON * residual)
        if found is None:
            longest = largest_step / float(np.abs(direction).max())
            found = _line_search(potential, at, value, direction, float(gradient @ direction), longest)
        if found is None:
            break
        at, value = found
        gradient = potential.gradient(at)
    if residual <= tolerance:
        return Minimum(at, tangents, residual, factors)
    raise ConvergenceError(
        f"Newton stopped after {tangents} tangents with residual {residual:.2e} N > {tolerance:.2e} N; "
        "press less deep, in smaller steps, or on a finer mesh"
    )


def _descent(hessian: sp.csc_matrix, gradient: Floats) -> tuple[Floats, Factors | None]:
    """Newton's direction, shifted towards steepest descent where the tangent is not positive along it.

    With it come the factors of the tangent, None where it had to be shifted.
    """
    diagonal = np.abs(hessian.diagonal())
    for shift in _SHIFTS:
        factors = _factorise(hessian if shift == 0 else hessian + sp.diags(shift * diagonal, format="csc"))
        direction = None if factors is None else factors.solve(-gradient)
        if direction is not None and np.isfinite(direction).all() and gradient @ direction < 0:
            return direction, factors if shift == 0 else None
    return -gradient / np.maximum(diagonal, diagonal.max() * 1e-12), None


def _factorise(matrix: sp.csc_matrix) -> Factors | None:
    """Symmetric factors in the given order; None where the matrix is singular."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            factors: Factors = spla.splu(
                matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
    except (RuntimeError, Warning):
        return None
    return factors


def _close_in(
    potential: Potential,
    at: Floats,
    value: float,
    gradient: Floats,
    direction: Floats,
    largest_step: float,
    target: float,
) -> tuple[Floats, float] | None:
    """The full step near the minimum, where energies only round, if it brings the gradient down to `target`."""
    slope = float(gradient @ direction)
    if not -_CLOSE * abs(value) <= slope < 0 or np.abs(direction).max() > largest_step:
        return None
    energy = potential.energy(at + direction)
    if np.isfinite(energy) and np.linalg.norm(potential.gradient(at + direction)) < target:
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
