"""The compressible neo-Hookean solid W = mu/2 (I1bar - 3) + kappa/2 (J - 1)^2, with J taken as an element's mean.

I1bar = J^(-2/3) tr(F^T F). Source: J. C. Simo, R. L. Taylor, K. S. Pister, "Variational and projection methods for the
volume constraint in finite deformation elasto-plasticity", CMAME 51 (1985); derivatives worked out here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.contact.layer import LayerMaterial

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class NeoHookean:
    """Shear modulus mu and bulk modulus kappa in pascals."""

    shear_modulus_pa: float
    bulk_modulus_pa: float

    def __post_init__(self) -> None:
        if not (self.shear_modulus_pa > 0 and 0 < self.bulk_modulus_pa < np.inf):
            raise ValueError(
                "a neo-Hookean solid needs positive, finite moduli, got "
                f"shear_modulus_pa={self.shear_modulus_pa}, bulk_modulus_pa={self.bulk_modulus_pa}"
            )

    @classmethod
    def from_layer(cls, material: LayerMaterial) -> NeoHookean:
        """The solid whose small strains are those of `material`; refuses nu = 1/2, where kappa is infinite."""
        nu, modulus = material.poisson_ratio, material.youngs_modulus_pa
        if nu >= 0.5:
            raise ValueError("the neohookean rung needs poisson_ratio < 0.5, got 0.5; 0.499 keeps volume as well")
        return cls(modulus / (2 * (1 + nu)), modulus / (3 * (1 - 2 * nu)))


@dataclass(frozen=True)
class Strain:
    """Deformation at the Gauss points of m elements.

    `push` = F grad N and `pull` = F^-T grad N, (m, 8, 24) with nodes and directions flattened; `jacobian` det F and
    `trace` tr(F^T F), (m, 8); `dilatation` the mean J of each element, (m,).
    """

    push: Floats
    pull: Floats
    jacobian: Floats
    trace: Floats
    dilatation: Floats


def strain(gradients: Floats, weights: Floats, displacement: Floats) -> Strain:
    """Strain under nodal displacements (m, 8, 3) in metres; see `HexMesh` for `gradients` and `weights`."""
    elements = len(gradients)
    deformation = np.swapaxes(displacement, 1, 2)[:, None] @ gradients
    deformation[..., [0, 1, 2], [0, 1, 2]] += 1
    cofactor = _cofactor(deformation)
    jacobian = (deformation[..., 0, :] * cofactor[..., 0, :]).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = cofactor / jacobian[..., None, None]
    return Strain(
        (gradients @ np.swapaxes(deformation, -1, -2)).reshape(elements, 8, 24),
        (gradients @ np.swapaxes(inverse, -1, -2)).reshape(elements, 8, 24),
        jacobian,
        (deformation**2).sum(axis=(-1, -2)),
        (weights * jacobian).sum(axis=1) / weights.sum(axis=1),
    )


def _cofactor(f: Floats) -> Floats:
    """J F^-T of (..., 3, 3) matrices: rows are cross products of the other two rows."""
    out = np.empty_like(f)
    for i in range(3):
        a, b = f[..., (i + 1) % 3, :], f[..., (i + 2) % 3, :]
        for j in range(3):
            k, m = (j + 1) % 3, (j + 2) % 3
            out[..., i, j] = a[..., k] * b[..., m] - a[..., m] * b[..., k]
    return out


def energy(solid: NeoHookean, weights: Floats, state: Strain) -> float:
    """Stored energy in joules; infinite where an element has turned inside out."""
    if not (state.jacobian > 0).all():
        return np.inf
    isochoric = 0.5 * solid.shear_modulus_pa * (state.jacobian ** (-2 / 3) * state.trace - 3)
    volumetric = 0.5 * solid.bulk_modulus_pa * (state.dilatation - 1) ** 2
    return float((weights * isochoric).sum() + (weights.sum(axis=1) * volumetric).sum())


def _moduli(solid: NeoHookean, state: Strain) -> tuple[Floats, Floats, Floats]:
    """mu J^(-2/3), p J and the factor of F^-T in the stress, each (m, 8)."""
    shear = solid.shear_modulus_pa * state.jacobian ** (-2 / 3)
    pressure = solid.bulk_modulus_pa * (state.dilatation - 1)[:, None] * state.jacobian
    return shear, pressure, shear * state.trace / 3 - pressure


def internal_force(solid: NeoHookean, weights: Floats, state: Strain) -> Floats:
    """Derivative of `energy` by the nodal displacements of each element (N), (m, 24)."""
    shear, _, pull_factor = _moduli(solid, state)
    out: Floats = np.einsum("mq,mqa->ma", weights * shear, state.push)
    out -= np.einsum("mq,mqa->ma", weights * pull_factor, state.pull)
    return out


def stiffness(solid: NeoHookean, gradients: Floats, weights: Floats, state: Strain) -> Floats:
    """Second derivative of `energy` by the nodal displacements of each element (N/m), (m, 24, 24).

    With f = push, g = pull, c = mu J^(-2/3), b = c I1/3 - p J, the sum over Gauss points of
    c (grad N_a . grad N_b) 1 - 2c/3 (f g + g f) + (2 c I1/9 + p J) g g + b (g g with directions swapped),
    and kappa/V G G from the mean dilatation, G = sum w J g.
    """
    elements = len(gradients)
    shear, pressure, swap = _moduli(solid, state)
    f, g = state.push, state.pull
    volume_slope = np.einsum("mq,mqa->ma", weights * state.jacobian, g)
    bulk = solid.bulk_modulus_pa / weights.sum(axis=1)
    left = (weights * (shear * state.trace / 9 + pressure / 2))[..., None] * g
    left -= (weights * shear * 2 / 3)[..., None] * f
    left = np.concatenate([left, (bulk / 2)[:, None, None] * volume_slope[:, None]], axis=1)
    right = np.concatenate([g, volume_slope[:, None]], axis=1)
    half = np.swapaxes(left, 1, 2) @ right
    out = half + np.swapaxes(half, 1, 2)
    swapped = np.swapaxes((weights * swap)[..., None] * g, 1, 2) @ g
    blocks = out.reshape(elements, 8, 3, 8, 3)
    blocks += np.swapaxes(swapped.reshape(elements, 8, 3, 8, 3), 2, 4)
    flat = np.swapaxes(gradients, 1, 2).reshape(elements, 8, 24)
    scalar = flat @ np.swapaxes(flat * np.repeat(weights * shear, 3, axis=1)[:, None], 1, 2)
    for i in range(3):
        blocks[:, :, i, :, i] += scalar
    return out
