"""How far off a linear skin is at large deflection: the von Karman disc.

A disc under a central patch load, simply supported and held in its plane at the rim, pre-stretched with tension N0.
Axisymmetric von Karman equations (S. Timoshenko, S. Woinowsky-Krieger, "Theory of Plates and Shells" (1959),
section 97), slope phi = w', radial tension N:

    D (phi'' + phi' / r - phi / r^2) = N phi + Q,        Q = load inside r / (2 pi r)
    r^2 N'' + 3 r N' = -(E h / 2) phi^2
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid, solve_bvp

from sensors.contact.skin import SkinMaterial


def disc_deflection(
    material: SkinMaterial, radius_m: float, patch_radius_m: float, force_n: float, *, stretching: bool = True
) -> float:
    """Central deflection (m) of a disc under `force_n` spread evenly over a central patch.

    With `stretching=False` the tension stays N0: the linear plate that `SkinCompliance` assumes. Raises RuntimeError
    where the boundary value problem does not converge.
    """
    stiffness = material.film.youngs_modulus_pa * material.film.thickness_m
    bending, n0, nu = material.bending_stiffness_nm, material.tension_n_per_m, material.film.poisson_ratio
    scale = force_n / (2 * np.pi * n0)  # order of the deflection
    stretch = stiffness * scale**2 / (2 * radius_m**2 * n0) if stretching else 0.0
    bend = bending / (n0 * radius_m**2)
    patch = patch_radius_m / radius_m
    inner = 1e-3

    # s = r / a, y = [slope a / scale, its derivative, N / N0, its derivative]
    def equations(s: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        load = np.minimum(s / patch, 1.0) ** 2 / s
        slope2 = (y[2] * y[0] + load) / bend - y[1] / s + y[0] / s**2
        tension2 = -(3 * s * y[3] + stretch * y[0] ** 2) / s**2
        return np.vstack((y[1], slope2, y[3], tension2))

    def edges(left: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
        # centre: slope linear in s, tension flat; rim: no moment, no radial displacement beyond the pre-stretch
        moment = right[1] + nu * right[0]
        in_plane = right[3] + (1 - nu) * (right[2] - 1)
        return np.array([left[0] - inner * left[1], left[3], moment, in_plane])

    s = np.unique(np.concatenate((np.geomspace(inner, 1, 200), np.linspace(inner, 1, 200))))
    guess = np.vstack((-np.minimum(s / patch**2, 1 / s), np.gradient(-1 / s, s), np.ones_like(s), np.zeros_like(s)))
    solution = solve_bvp(equations, edges, s, guess, tol=1e-5, max_nodes=20000)
    if not solution.success:
        raise RuntimeError(f"the disc under {force_n} N did not converge: {solution.message}")
    fine = np.linspace(inner, 1, 4000)
    deflection = -cumulative_trapezoid(solution.sol(fine)[0], fine)[-1]
    return float(deflection * scale)


def linear_excess(material: SkinMaterial, radius_m: float, patch_radius_m: float, force_n: float) -> float:
    """Relative error of the linear deflection against the stretching disc (0.05: the linear skin sinks 5 % too far)."""
    stretched = disc_deflection(material, radius_m, patch_radius_m, force_n)
    linear = disc_deflection(material, radius_m, patch_radius_m, force_n, stretching=False)
    return linear / stretched - 1
