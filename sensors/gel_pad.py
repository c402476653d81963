"""A flat gel on a rigid window: the contact and the displacement that a gel camera looks at."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.solver import NO_SURFACE, ContactSolution, solve_indentation, solve_load
from sensors.contact.thickness import refuse_depth, refuse_through


@dataclass(frozen=True)
class GelPad:
    """A gel of `material` on `grid`, float32; the `layer` rung. Build once, press often."""

    grid: Grid
    material: LayerMaterial

    @cached_property
    def compliance(self) -> LayerCompliance:
        """The layer's compliance on the grid."""
        return LayerCompliance(self.grid, self.material, np.float32)

    def solve(
        self,
        gap: NDArray[np.floating],
        *,
        load_n: float | None = None,
        depth_mm: float | None = None,
        initial: NDArray[np.floating] | None = None,
    ) -> ContactSolution:
        """Press an object of `gap` (n, n; metres, inf where there is none) with a load or to a depth.

        `initial` (n, n) is a pressure to start from, as along a path of indentations.

        Raises:
            ValueError: neither or both of load and depth, a wrong shape, a load that nothing carries, or a press as
                deep as the gel is thick.
        """
        if (load_n is None) == (depth_mm is None):
            raise ValueError(f"a press needs load_n or depth_mm, one of them: got load_n={load_n}, depth_mm={depth_mm}")
        if load_n is not None:
            contact = solve_load(self.compliance, gap, load_n, initial=initial)
            refuse_through(contact, self.material.thickness_m)
            return contact
        assert depth_mm is not None
        refuse_depth(depth_mm * 1e-3, self.material.thickness_m)
        return solve_indentation(self.compliance, gap, depth_mm * 1e-3, initial=initial)

    def displacement(self, contact: ContactSolution) -> NDArray[np.floating]:
        """Displacement (n, n) of the membrane into the gel, in metres, inside and outside the contact."""
        return self.compliance.displacement(contact.pressure)


def ball_gap(grid: Grid, radius_m: float, x_m: float = 0.0, y_m: float = 0.0) -> NDArray[np.float64]:
    """Gap (n, n) in metres below a ball that touches at (x, y); `NO_SURFACE` beyond its equator."""
    x, y = grid.coordinates()
    square = (x - x_m) ** 2 + (y - y_m) ** 2
    under = square < radius_m**2
    return np.where(under, radius_m - np.sqrt(np.where(under, radius_m**2 - square, 0.0)), NO_SURFACE)


def press_ball_to_radius(
    pad: GelPad, ball_radius_m: float, contact_radius_m: float, x_m: float = 0.0, y_m: float = 0.0
) -> ContactSolution:
    """The press of a ball whose contact circle has the given radius, by bisection on the depth.

    The radius of a contact is that of the circle of its area. ValueError where the ball is not wider than the contact,
    or the gel not as thick as the press is deep.
    """
    if not 0 < contact_radius_m < ball_radius_m:
        raise ValueError(
            f"the contact radius must lie between 0 and the ball's {ball_radius_m * 1e3:g} mm, "
            f"got {contact_radius_m * 1e3:g} mm"
        )
    gap = ball_gap(pad.grid, ball_radius_m, x_m, y_m)
    shallow, deep = 0.0, 2 * ball_radius_m
    contact: ContactSolution | None = None
    for _ in range(_BISECTIONS):
        depth = (shallow + deep) / 2
        initial = None if contact is None else contact.pressure
        # on the way the bisection may look deeper than the gel is thick
        contact = solve_indentation(pad.compliance, gap, depth, initial=initial)
        if contact_radius(contact) < contact_radius_m:
            shallow = depth
        else:
            deep = depth
    assert contact is not None
    refuse_through(contact, pad.material.thickness_m)
    return contact


def contact_radius(contact: ContactSolution) -> float:
    """Radius (m) of the circle that has the contact's area."""
    return math.sqrt(float(contact.contact.sum()) * contact.grid.cell_area_m2 / math.pi)


_BISECTIONS = 11
"""Leaves 1/1000 of the ball's radius; a cell of the contact's edge is coarser than that."""
