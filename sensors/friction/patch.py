"""A patch of skin on an in-plane spring, dragged along by many LuGre elements under one moving body.

The patch moves as a whole (displacement u, mass m, spring k, damper c); each element joins it to the body at a point of
its own, under its own normal force, and so sticks or slips on its own:

    m u'' = sum F_i(z_i, V_i - u') - k u - c u'

Same scheme as `body`: damping implicit, springs symplectic, substeps of at most 1 / sqrt((k + sum sigma0) / m).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sensors.friction.body import count_substeps
from sensors.friction.lugre import Array, LuGre
from sensors.friction.patch_kernel import advance_elements


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

    @cached_property
    def longest_step(self) -> float:
        """1 / sqrt((k + sum sigma0) / m) in seconds."""
        return math.sqrt(self.mass_kg / (self.stiffness + float(np.sum(self.law.stiffness))))

    @cached_property
    def _sigmas(self) -> Array:
        """Stiffness, damping and viscosity of each element (3, n)."""
        law = self.law
        return np.stack(np.broadcast_arrays(*(np.atleast_1d(s) for s in (law.stiffness, law.damping, law.viscosity))))

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
        stability needs. Raises ValueError as `count_substeps`.
        """
        count = count_substeps(dt_s, self.longest_step, substeps, self.mass_kg)
        law = self.law
        patch, bristle, slip, force = advance_elements(
            np.concatenate((state.displacement, state.velocity)),
            state.bristle,
            state.slip,
            np.ascontiguousarray(drive, dtype=np.float64),
            np.ascontiguousarray(next_drive, dtype=np.float64),
            np.ascontiguousarray(normal_force, dtype=np.float64),
            self._sigmas,
            (law.static, law.dynamic, law.stribeck_m_per_s),
            (self.mass_kg, self.stiffness, self.damping),
            (count, dt_s / count),
        )
        return PatchState(patch[:2], patch[2:], bristle, slip, force)

    def utilisation(self, state: PatchState, drive: Array, normal_force: Array) -> Array:
        """|sigma0 z| / g of each element (n,): 0 unstrained, 1 in steady sliding; 0 without load."""
        velocity = drive - state.velocity
        level = self.law.level(normal_force, np.sqrt((velocity**2).sum(axis=-1)))
        pull = self.law.stiffness * np.sqrt((state.bristle**2).sum(axis=-1))
        return np.divide(pull, level, out=np.zeros(len(state.bristle)), where=level > 0)
