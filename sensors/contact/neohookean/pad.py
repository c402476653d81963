"""A bonded hyperelastic pad, pressed to depths or by loads along a warm-started path."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sensors.contact.layer import LayerMaterial
from sensors.contact.neohookean.assembly import Assembly
from sensors.contact.neohookean.contact import TopContact
from sensors.contact.neohookean.material import NeoHookean
from sensors.contact.neohookean.mesh import PadMesh
from sensors.contact.neohookean.newton import minimise
from sensors.contact.neohookean.ordering import nested_dissection
from sensors.contact.neohookean.press import Press
from sensors.contact.neohookean.solution import PadSolution
from sensors.contact.neohookean.surface import Surface
from sensors.contact.solver import ConvergenceError
from sensors.contact.thickness import refuse_depth

Floats = NDArray[np.float64]

_STIFFNESS = 100.0
"""Contact stiffness over E / h, per area; multipliers remove what penetration it leaves."""

_FORCE_TOLERANCE = 1e-8
_GAP_TOLERANCE = 1e-5
_UPDATES = 12
_LARGEST_STEP = 0.15
"""Largest motion of a node in one iteration, in thicknesses."""

_SUBSTEPS = 5
"""How often a step of the path is halved before it counts as failed."""


@dataclass(frozen=True)
class _State:
    """Where a step starts: displacements, vertical loads of the top nodes (N), indentation (m)."""

    displacement: Floats
    normal_load: Floats
    indentation_m: float

    @property
    def load_n(self) -> float:
        """Load on the mesh (N)."""
        return float(self.normal_load.sum())

    @classmethod
    def after(cls, solution: PadSolution) -> _State:
        """The state that a solution leaves behind."""
        return cls(solution.displacement, solution.normal_load, solution.indentation_m)


def contact_stiffness(mesh: PadMesh, material: LayerMaterial) -> Floats:
    """Stiffness (N/m) of the contact at each top node, (n_top,)."""
    return _STIFFNESS * material.youngs_modulus_pa / material.thickness_m * mesh.top_area


class NeoHookeanPad:
    """The `neohookean` rung on `mesh`.

    Tolerances: forces out of balance below 1e-8 of the load or of E h^2 / 100 if that is larger; no node penetrates or
    pulls over more than 1e-5 of the thickness. Steps that do not converge are halved, up to five times.
    """

    def __init__(self, mesh: PadMesh, material: LayerMaterial) -> None:
        self.mesh = mesh
        self.material = material
        self.solid = NeoHookean.from_layer(material)
        self.thickness_m = float(np.ptp(mesh.nodes[:, 2]))
        if not np.isclose(self.thickness_m, material.thickness_m, rtol=1e-9):
            raise ValueError(f"the mesh is {self.thickness_m} m thick, the material {material.thickness_m} m")
        nodes = nested_dissection(mesh.points)
        order = (3 * nodes[:, None] + np.arange(3)).ravel()
        self.assembly = Assembly(mesh, self.solid, order[~mesh.fixed().ravel()[order]])
        self._stiffness = contact_stiffness(mesh, material)

    def press_depths(self, surface: Surface, depths_m: Iterable[float]) -> Iterator[PadSolution]:
        """Solutions at the depths (m) in turn, each started from the one before.

        Raises ValueError for a depth that is not finite or exceeds the thickness, or a surface that a quarter mesh
        cannot hold; ConvergenceError where the halved steps fail too (an edge that folds the elements, a pad squeezed
        out).
        """
        self._check(surface)
        state = self._rest()
        for depth in depths_m:
            refuse_depth(depth, self.thickness_m)
            solution = self._walk(surface, state, depth, None)
            state = _State.after(solution)
            yield solution

    def press_loads(self, surface: Surface, loads_n: Iterable[float]) -> Iterator[PadSolution]:
        """Solutions under the loads (N) in turn, each started from the one before; errors as `press_depths`."""
        self._check(surface)
        state = self._rest()
        for load in loads_n:
            if not (np.isfinite(load) and load >= 0):
                raise ValueError(f"load must be finite and >= 0, got {load} N")
            if load == 0:
                state = self._rest()
                rest = TopContact(self.mesh, surface, state.normal_load, self._stiffness)
                yield self._solution(rest, state.displacement, 0.0, 0, 0.0)
                continue
            solution = self._walk(surface, state, None, load / self.mesh.copies)
            state = _State.after(solution)
            yield solution

    def _check(self, surface: Surface) -> None:
        if self.mesh.quarter and not surface.quarter:
            raise ValueError("a quarter mesh needs a surface that x -> -x and y -> -y leave alike; use a whole mesh")

    def _rest(self) -> _State:
        return _State(np.zeros_like(self.mesh.nodes), np.zeros(len(self.mesh.top)), 0.0)

    def _walk(self, surface: Surface, start: _State, depth: float | None, load: float | None) -> PadSolution:
        """One step of the path, in halves where it fails."""
        state, share, done = start, 1.0, 0.0
        while True:
            fraction = min(1.0, done + share)
            aim_depth = None if depth is None else start.indentation_m + fraction * (depth - start.indentation_m)
            aim_load = None if load is None else start.load_n + fraction * (load - start.load_n)
            try:
                solution = self._settle(surface, state, aim_depth, aim_load)
            except ConvergenceError as error:
                share /= 2
                if share < 0.5**_SUBSTEPS:
                    goal = f"{depth} m" if load is None else f"{load * self.mesh.copies} N"
                    raise ConvergenceError(f"no equilibrium on the way to {goal}: {error}") from error
                continue
            if fraction == 1.0:
                return solution
            done = fraction
            state = _State.after(solution)

    def _settle(self, surface: Surface, start: _State, depth: float | None, load: float | None) -> PadSolution:
        """Newton inside, multipliers outside, until no node penetrates by more than the tolerance."""
        contact = TopContact(self.mesh, surface, start.normal_load, self._stiffness)
        displacement, indentation = start.displacement, start.indentation_m if depth is None else depth
        if load is not None and start.load_n == 0:
            indentation = self._touch(contact)
        scale = max(load or 0.0, start.load_n, self.material.youngs_modulus_pa * self.thickness_m**2 / 100)
        iterations, factors = 0, None
        for _ in range(_UPDATES):
            press = Press(self.assembly, contact, indentation, load)
            found = minimise(
                press,
                press.pack(displacement),
                _FORCE_TOLERANCE * scale,
                _LARGEST_STEP * self.thickness_m,
                factors=factors,
            )
            factors = found.factors
            displacement, indentation = press.unpack(found.at)
            iterations += found.iterations
            gap = contact.gap(displacement, indentation)
            carried = contact.normal_load(gap)
            if np.abs(np.where(carried > 0, gap, np.minimum(gap, 0))).max() <= _GAP_TOLERANCE * self.thickness_m:
                return self._solution(contact, displacement, indentation, iterations, found.residual)
            contact = replace(contact, multiplier=carried)
        raise ConvergenceError(f"contact still open or penetrated by {np.abs(gap[carried > 0]).max():.1e} m")

    def _touch(self, contact: TopContact) -> float:
        """An indentation at which the first node of the resting pad is in contact."""
        gaps = contact.gap(np.zeros_like(self.mesh.nodes), 0.0)
        return float(gaps.min()) + 1e-3 * self.thickness_m

    def _solution(
        self, contact: TopContact, displacement: Floats, indentation: float, iterations: int, residual: float
    ) -> PadSolution:
        gap = contact.gap(displacement, indentation)
        load = contact.normal_load(gap)
        return PadSolution(
            self.mesh,
            displacement,
            self.assembly.force(displacement),
            load,
            gap,
            indentation,
            iterations,
            residual,
        )
