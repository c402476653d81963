"""The skin in its own plane: how far friction drags it, and the mass that moves with it.

Each component of the displacement obeys K lap u = -traction on the frame that holds the skin, with
K = 2 E h / ((1 + nu) (3 - nu)): the direction-free part of the plane-stress (Kelvin) solution, whose point force gives
u = F / (2 pi K) ln(1/r) + an anisotropic part that does not vary with the distance and is left out. The film carries
all of it: what the canvas adds in its plane is left out, as in the skin's bending.

Source: A. E. H. Love, "A treatise on the mathematical theory of elasticity" (1927), section 148 (plane point force).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerMaterial
from sensors.contact.skin import sine_basis
from sensors.contact.solver import ContactSolution
from sensors.contact.tangential import LayerTangential


@dataclass(frozen=True)
class InPlaneSkin:
    """What friction on one contact has to move: spring (N/m), mass (kg) and sine modes of u per newton (m/N)."""

    stiffness: float
    mass_kg: float
    modes: NDArray[np.floating]


def in_plane_pad(film: LayerMaterial, areal_mass_kg_m2: float, contact: ContactSolution) -> InPlaneSkin:
    """A film bonded to a plate under a traction that is shared out like the pressure of `contact`, as one patch.

    Its displacement is the mean of those along and across the traction; sheared through its thickness, a third of its
    mass moves along.
    """
    grid = contact.grid
    traction = np.asarray(contact.pressure, np.float64) / contact.force_n
    layer, none = LayerTangential(grid, film), np.zeros_like(traction)
    displacement = (
        layer.displacement(np.stack([traction, none]))[0] + layer.displacement(np.stack([none, traction]))[1]
    ) / 2
    compliance = float((traction * displacement).sum()) * grid.cell_area_m2
    moving = areal_mass_kg_m2 / 3 * float((displacement**2).sum()) * grid.cell_area_m2
    return InPlaneSkin(1 / compliance, moving / compliance**2, field_modes(displacement))


def field_modes(field: NDArray[np.floating]) -> NDArray[np.floating]:
    """Sine modes (n, n) of values (n, n) at the cells of a grid."""
    n = len(field)
    basis = sine_basis((np.arange(n) + 0.5) / n, n)
    return np.asarray(basis.T @ field @ basis)


def in_plane_modulus(film: LayerMaterial) -> float:
    """K in N/m."""
    nu = film.poisson_ratio
    return 2 * film.youngs_modulus_pa * film.thickness_m / ((1 + nu) * (3 - nu))


def in_plane_skin(
    grid: Grid, film: LayerMaterial, areal_mass_kg_m2: float, traction_modes: NDArray[np.floating]
) -> InPlaneSkin:
    """The skin under a traction of the given sine modes, which must belong to a net force of one newton.

    The displacement of the contact is the traction's mean of u; the mass is Rayleigh's, from the shape of u.
    """
    k = np.pi * np.arange(1, grid.n + 1) / grid.size_m
    traction = np.asarray(traction_modes, dtype=np.float64)
    displacement = traction / (in_plane_modulus(film) * (k[:, None] ** 2 + k[None, :] ** 2))
    compliance = float((traction * displacement).sum()) * grid.cell_area_m2
    moving = areal_mass_kg_m2 * float((displacement**2).sum()) * grid.cell_area_m2
    return InPlaneSkin(1 / compliance, moving / compliance**2, displacement)
