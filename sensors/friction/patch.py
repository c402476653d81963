"""A patch of skin on an in-plane spring, dragged along by many LuGre elements under one moving body.

The patch moves as a whole (displacement u, mass m, spring k, damper c); each element joins it to the body at a point of
its own, under its own normal force, and so sticks or slips on its own:

    m u'' = sum F_i(z_i, V_i - u') - k u - c u'

Same scheme as `body`: damping implicit, springs symplectic, substeps of at most 1 / sqrt((k + sum sigma0) / m).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sensors.friction.body import count_substeps
from sensors.friction.lugre import Array, LuGre


@dataclass(frozen=True)
class PatchState:
    """Displacement and velocity of the patch (2,); bristles, irreversible slip (m), forces (N) of elements (n, 2)."""

    displacement: Array
    velocity: Array
    bristle: Array
    slip: Array
    force: Array

    @classmethod
    def at_rest(cls, elements: int) -> PatchState:
        """Nothing displaced, nothing strained."""
        plane, points = np.zeros(2), np.zeros((elements, 2))
        return cls(plane, plane, points, points, points)


@dataclass(frozen=True)
class SkinPatch:
    """Friction law with one stiffness per element (n,), and mass (kg), spring (N/m) and damper (N s/m) of the patch."""

    law: LuGre
    mass_kg: float
    stiffness: float
    damping: float

    @property
    def longest_step(self) -> float:
        """1 / sqrt((k + sum sigma0) / m) in seconds."""
        return math.sqrt(self.mass_kg / (self.stiffness + float(np.sum(self.law.stiffness))))

    def advance(
        self,
        state: PatchState,
        drive: Array,
        next_drive: Array,
        normal_force: Array,
        dt_s: float,
        substeps: int | None = None,
    ) -> PatchState:
        """The state after `dt_s` in which the body's velocity goes from `drive` to `next_drive`.

        drive (1, 2) or (n, 2) in m/s at each element; normal_force (n,) in newtons. `substeps` None takes what
        stability needs. Raises ValueError where `substeps` are too few.
        """
        count = count_substeps(dt_s, self.longest_step, substeps)
        h = dt_s / count
        law = self.law
        loaded = (normal_force > 0)[:, None]
        sigma0, sigma1, sigma2 = (
            np.asarray(sigma, dtype=np.float64)[..., None] * loaded
            for sigma in (law.stiffness, law.damping, law.viscosity)
        )
        u, w, slip = state.displacement, state.velocity, state.slip
        z = law.hold(state.bristle, normal_force) * loaded
        change = np.zeros_like(z)
        relative = drive - w
        forgotten, reach = self._memory(relative, normal_force, h)
        for number in range(count):
            body = drive + (next_drive - drive) * ((number + 0.5) / count)
            grip = sigma1 * reach + sigma2 * h
            impulse = ((h * sigma0 - sigma1 * forgotten) * z + grip * body).sum(axis=0) - h * self.stiffness * u
            w = (self.mass_kg * w + impulse) / (self.mass_kg + h * self.damping + grip.sum())
            relative = body - w
            forgotten, reach = self._memory(relative, normal_force, h)
            change = (reach * relative - forgotten * z) * loaded
            z = z + change
            slip = slip + (h * relative - change) * loaded
            u = u + h * w
        force = sigma0 * z + sigma1 * change / h + sigma2 * relative
        return PatchState(u, w, z, slip, force)

    def _memory(self, velocity: Array, normal_force: Array, h: float) -> tuple[Array, Array]:
        forgotten, reach = self.law.memory(velocity, normal_force, h)
        return forgotten[:, None], reach[:, None]

    def utilisation(self, state: PatchState, drive: Array, normal_force: Array) -> Array:
        """|sigma0 z| / g of each element (n,): 0 unstrained, 1 in steady sliding; 0 without load."""
        velocity = drive - state.velocity
        level = self.law.level(normal_force, np.sqrt((velocity**2).sum(axis=-1)))
        pull = self.law.stiffness * np.sqrt((state.bristle**2).sum(axis=-1))
        return np.divide(pull, level, out=np.zeros(len(state.bristle)), where=level > 0)
