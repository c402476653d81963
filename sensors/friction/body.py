"""Free bodies under LuGre friction: semi-implicit steps, as short as the bristles demand.

Damping is taken implicitly, the spring of the bristles symplectically (the new velocity moves the bristle): stable
while the step is at most 1 / sqrt(sigma0 / m), so a step of the caller is cut into substeps of that length.
"""

from __future__ import annotations

import math

import numpy as np

from sensors.friction.lugre import Array, LuGre

MOST_SUBSTEPS = 1000
"""Of one step of the caller; usual skins take 6 to 25."""


def needed_step(stiffness: float | Array, mass_kg: float | Array) -> float:
    """Longest stable step (s): 1 / sqrt(sigma0 / m) of the stiffest element."""
    mass = np.asarray(mass_kg)
    if not np.all((mass > 0) & (mass < np.inf)):
        raise ValueError(f"expected mass_kg > 0, got {mass_kg}")
    return 1 / math.sqrt(float(np.max(np.asarray(stiffness, dtype=np.float64) / mass_kg)))


def count_substeps(
    dt_s: float, longest_s: float, substeps: int | None = None, mass_kg: float | Array | None = None
) -> int:
    """How many substeps a step of `dt_s` needs; refuses a given number that is too small.

    Raises ValueError unless dt_s > 0, where `substeps` leaves steps longer than `longest_s`, and where none are given
    and more than `MOST_SUBSTEPS` would be needed; `mass_kg` is named in that case.
    """
    if not (0 < dt_s < math.inf and longest_s > 0):
        raise ValueError(f"dt_s must be > 0, got {dt_s}, and so must the longest stable step, {longest_s:.3g} s")
    needed = max(1, math.ceil(dt_s / longest_s * (1 - 1e-12)))
    if substeps is None and needed > MOST_SUBSTEPS:
        moved = "" if mass_kg is None else f" of {float(np.min(mass_kg)):.3g} kg"
        raise ValueError(
            f"a step of {dt_s:.3g} s is too long for a mass{moved} on such stiff bristles: they need steps of "
            f"{longest_s:.3g} s, {needed} in each (at most {MOST_SUBSTEPS}): take shorter steps, a larger mass or "
            "softer bristles"
        )
    if substeps is None:
        return needed
    if substeps < needed:
        raise ValueError(
            f"a step of {dt_s:.3g} s in {substeps} substeps cannot be stable: the bristles need steps of at most "
            f"{longest_s:.3g} s, so {needed} substeps"
        )
    return substeps


def advance_body(
    law: LuGre,
    mass_kg: float | Array,
    velocity: Array,
    bristle: Array,
    applied_force: Array,
    normal_force: Array,
    dt_s: float,
    substeps: int | None = None,
) -> tuple[Array, Array, Array]:
    """Move free bodies over a resting surface for `dt_s` under a constant applied force.

    velocity, bristle, applied_force (..., d); normal_force (...). Returns velocity (m/s), bristle (m) and the distance
    moved (m), each (..., d). `substeps` None takes as many as stability needs. Raises ValueError as `count_substeps`.
    """
    count = count_substeps(dt_s, needed_step(law.stiffness, mass_kg), substeps, mass_kg)
    h = dt_s / count
    mass = np.asarray(mass_kg, dtype=np.float64)[..., None]
    loaded = (np.asarray(normal_force) > 0)[..., None]
    sigma0, sigma1, sigma2 = (
        np.asarray(sigma, dtype=np.float64)[..., None] * loaded for sigma in (law.stiffness, law.damping, law.viscosity)
    )
    bristle = law.hold(bristle, normal_force) * loaded
    moved = np.zeros(np.shape(velocity))
    for _ in range(count):
        forgotten, reach = (part[..., None] for part in law.memory(velocity, normal_force, h))
        # sigma1 acts on the bristle's change over the step, -forgotten z + reach v', which stays small in sliding
        impulse = h * applied_force - (h * sigma0 - sigma1 * forgotten) * bristle
        velocity = (mass * velocity + impulse) / (mass + sigma1 * reach + sigma2 * h)
        bristle = law.relax(bristle, velocity, normal_force, h)
        moved = moved + h * velocity
    return velocity, bristle, moved
