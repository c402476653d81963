"""A hyperelastic pad that replays the press of one indenter along its axis, in the modes it was trained with."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sensors.contact.layer import LayerMaterial
from sensors.contact.neohookean.contact import TopContact
from sensors.contact.neohookean.newton import minimise
from sensors.contact.neohookean.pad import contact_stiffness
from sensors.contact.neohookean.solution import PadSolution
from sensors.contact.neohookean.surface import Surface
from sensors.contact.neohookean_reduced.potential import ReducedPress, ReducedSolid
from sensors.contact.solver import ConvergenceError

Floats = NDArray[np.float64]

_FORCE_TOLERANCE = 1e-7
_LARGEST_STEP = 0.15
_SAME_SURFACE = 1e-6
"""How far, in thicknesses, a surface may differ from the trained one."""

_BEYOND = 1 + 1e-9


@dataclass(frozen=True)
class Trained:
    """The path of the full model that a reduced one was made from; the first step is at rest.

    `depths_m` and `forces_n` (steps,) rise; `amplitudes` (steps, modes); `normal_load` (steps, n_top) in newtons on the
    mesh; `gap` (n_top,) the surface above the undeformed top.
    """

    depths_m: Floats
    forces_n: Floats
    amplitudes: Floats
    normal_load: Floats
    gap: Floats


@dataclass(frozen=True)
class ReducedPad:
    """The `neohookean-reduced` rung: one indenter, one axis, depths up to the trained one.

    A step starts from the trained steps on either side of it, so it does not depend on the steps before. Multipliers
    are brought up to date until no node penetrates or pulls over `gap_tolerance` thicknesses, `updates` times at most:
    fewer modes than nodes in contact cannot close every gap.
    """

    solid: ReducedSolid
    material: LayerMaterial
    trained: Trained
    updates: int = 2
    gap_tolerance: float = 1e-4

    @property
    def modes(self) -> int:
        """Size of the basis."""
        return self.solid.basis.shape[1]

    def press_depths(self, surface: Surface, depths_m: Iterable[float]) -> Iterator[PadSolution]:
        """Solutions at the depths (m), which may come in any order.

        Their `internal_force` is NaN: a sample of elements does not know it. Raises ValueError for another surface or
        place than the trained one, or a depth beyond the trained range; ConvergenceError where Newton stops.
        """
        self._check(surface)
        deepest = float(self.trained.depths_m[-1])
        for depth in depths_m:
            if not np.isfinite(depth) or depth > deepest * _BEYOND:
                raise ValueError(
                    f"neohookean-reduced was trained up to a depth of {deepest:.6g} m, asked for {depth:.6g} m; "
                    "train it deeper or use neohookean"
                )
            yield self._settle(surface, depth, None) if depth > 0 else self._rest(surface, depth)

    def press_loads(self, surface: Surface, loads_n: Iterable[float]) -> Iterator[PadSolution]:
        """Solutions under the loads (N); errors as `press_depths`."""
        self._check(surface)
        heaviest = float(self.trained.forces_n[-1])
        for load in loads_n:
            if not (np.isfinite(load) and load >= 0):
                raise ValueError(f"load must be finite and >= 0, got {load} N")
            if load > heaviest * _BEYOND:
                raise ValueError(
                    f"neohookean-reduced was trained up to a load of {heaviest:.6g} N, asked for {load:.6g} N; "
                    "train it deeper or use neohookean"
                )
            yield self._settle(surface, None, load) if load > 0 else self._rest(surface, 0.0)

    def _check(self, surface: Surface) -> None:
        """Refuse a surface that is not the trained one at the place where it was trained."""
        x, y = self.solid.mesh.nodes[self.solid.mesh.top, :2].T
        off = np.abs(surface.jet(x, y).gap - self.trained.gap)
        worst = int(np.argmax(off))
        if not off[worst] <= _SAME_SURFACE * self.material.thickness_m:
            raise ValueError(
                "neohookean-reduced replays only the indenter and the axis that it was trained with, and this surface "
                f"is {off[worst]:.3g} m off at x = {x[worst]:.3g} m, y = {y[worst]:.3g} m: another indenter or a "
                "contact that moved; train it for this one or use neohookean"
            )

    def _rest(self, surface: Surface, depth: float) -> PadSolution:
        mesh = self.solid.mesh
        return self._solution(np.zeros(self.modes), np.zeros(len(mesh.top)), self.trained.gap - depth, depth, 0, 0.0)

    def _start(self, known: Floats, at: float) -> tuple[Floats, Floats, float]:
        """Amplitudes, loads and depth between the trained steps on either side of `at` in `known`."""
        after = int(np.clip(np.searchsorted(known, at), 1, len(known) - 1))
        share = (at - known[after - 1]) / (known[after] - known[after - 1])
        path = self.trained

        def between(values: Floats) -> Floats:
            return np.asarray((1 - share) * values[after - 1] + share * values[after], np.float64)

        return between(path.amplitudes), between(path.normal_load), float(between(path.depths_m))

    def _settle(self, surface: Surface, depth: float | None, load: float | None) -> PadSolution:
        """Newton inside, multipliers outside."""
        mesh, path = self.solid.mesh, self.trained
        if depth is not None:
            amplitudes, carried, indentation = self._start(path.depths_m, depth)
        else:
            assert load is not None
            amplitudes, carried, indentation = self._start(path.forces_n, load)
        thickness = self.material.thickness_m
        scale = max(float(carried.sum()), self.material.youngs_modulus_pa * thickness**2 / 100)
        contact = TopContact(mesh, surface, carried, contact_stiffness(mesh, self.material))
        share = None if load is None else load / mesh.copies
        longest = _LARGEST_STEP * thickness / float(np.abs(self.solid.basis).max())
        iterations, factors = 0, None
        for _ in range(self.updates):
            press = ReducedPress(self.solid, contact, indentation, share)
            try:
                found = minimise(press, press.pack(amplitudes), _FORCE_TOLERANCE * scale, longest, factors=factors)
            except ConvergenceError as error:
                raise ConvergenceError(
                    f"reduced press found no equilibrium with {self.modes} modes: {error}"
                ) from error
            factors = found.factors
            amplitudes, indentation = press.unpack(found.at)
            iterations += found.iterations
            gap = contact.gap(press.top(amplitudes), indentation)
            carried = contact.normal_load(gap)
            if np.abs(np.where(carried > 0, gap, np.minimum(gap, 0))).max() <= self.gap_tolerance * thickness:
                break
            contact = replace(contact, multiplier=carried)
        return self._solution(amplitudes, carried, gap, indentation, iterations, found.residual)

    def _solution(
        self, amplitudes: Floats, carried: Floats, gap: Floats, depth: float, iterations: int, residual: float
    ) -> PadSolution:
        displacement = (self.solid.basis @ amplitudes).reshape(-1, 3)
        unknown = np.full_like(displacement, np.nan)
        return PadSolution(self.solid.mesh, displacement, unknown, carried, gap, depth, iterations, residual)
