"""The skin under a moving object, integrated from first to last motion: what sticks, what slips, what it drags."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.contact.layer import LayerMaterial
from sensors.friction.lugre import LuGre
from sensors.friction.patch import PatchState, SkinPatch
from sensors.fvsight import FORCE_RATE_HZ
from sensors.slide.crowns import Crowns
from sensors.slide.membrane import InPlaneSkin
from sensors.slide.path import Path
from sensors.slide.recording import GROSS, PARTIAL, STICK
from sensors.slide.scene import Friction
from sensors.slide.track import Cells, Track

Array = NDArray[np.float64]

_BREAK = 1 - np.exp(-1)
"""Utilisation at which an element counts as loose: a Coulomb element of the same stiffness breaks at this distance."""


BLOCK = 2000
"""Samples integrated at a time: what each cell carries is held for no more, however long the trial."""


@dataclass(frozen=True)
class Drag:
    """History (t, ...) of integrated samples.

    skin_shift (t, 2; m), exchanged (t, n; N) what each cell carries beyond the smooth contact, shear of each cell
    (t, n, 2; N), slip (t,; m, mean over the load), slip_share (t,; of the load), stick_ratio (t,; of the area in
    contact).
    """

    skin_shift: Array
    exchanged: Array
    shear: Array
    slip: Array
    slip_share: Array
    stick_ratio: Array


def weave_stiffness(friction: Friction, film: LayerMaterial | None) -> float:
    """Shear stiffness (Pa/m) of a cell: crowns of the weave and the film's shear in series; None: the crowns alone."""
    weave = friction.weave_mpa_per_mm * 1e9
    if film is None:
        return weave
    shear_modulus = film.youngs_modulus_pa / (2 * (1 + film.poisson_ratio))
    return 1 / (1 / weave + film.thickness_m / shear_modulus)


def drag(
    patch: SkinPatch,
    friction: Friction,
    track: Track,
    path: Path,
    travel: Array,
    load: Array,
    crowns: Crowns | None,
    block: int = BLOCK,
) -> Iterator[Drag]:
    """Integrate the skin under `travel` (t,) and `load` (t,; N) along a track; starts at rest and unstrained.

    Gives the history `block` samples at a time; where a block ends has no bearing on the figures.
    """
    cells, samples, elements = track.cells, len(travel), len(track.cells.area)
    dt = 1 / FORCE_RATE_HZ
    rate = np.gradient(travel) / dt if samples > 1 else np.zeros(samples)
    state = PatchState.at_rest(elements)
    watch = _SlipWatch(friction, elements)
    drive = _drive(path, cells, float(travel[0]), float(rate[0]))
    for first in range(0, samples, block):
        smooth = track.cell_load(travel[first : first + block], load[first : first + block])
        count = len(smooth)
        shift, shear, exchanged = np.zeros((count, 2)), np.zeros((count, elements, 2)), np.empty((count, elements))
        slip, slip_share, stick_ratio = np.zeros(count), np.zeros(count), np.ones(count)
        for at, i in enumerate(range(first, first + count)):
            carried = smooth[at] if crowns is None else crowns.exchange(smooth[at], state.slip)
            exchanged[at] = carried - smooth[at]
            if i == 0:
                continue
            next_drive = _drive(path, cells, float(travel[i]), float(rate[i]))
            before, state = state, patch.advance(state, drive, next_drive, carried, dt)
            drive = next_drive
            share = carried / max(float(carried.sum()), 1e-12)
            speed = _length(state.slip - before.slip) / dt
            loose = watch.see(i, speed, patch.utilisation(state, drive, carried))
            slip_share[at] = share @ loose
            touched = cells.area * (carried > 0)
            stick_ratio[at] = 1 - touched @ loose / max(float(touched.sum()), 1e-12)
            slip[at] = share @ _length(state.slip)
            shift[at], shear[at] = state.displacement, state.force
        yield Drag(shift, exchanged, shear, slip, slip_share, stick_ratio)


def slip_states(friction: Friction, slip_share: Array) -> NDArray[np.uint8]:
    """STICK, PARTIAL or GROSS (t,) by the share of the load that slips."""
    state = np.full(len(slip_share), STICK, np.uint8)
    state[slip_share >= friction.partial_share] = PARTIAL
    state[slip_share >= friction.gross_share] = GROSS
    return state


def presliding_distance(patch: SkinPatch, load: Array, share: float) -> float:
    """How far (m) a slow object moves until `share` of the load (n,) slips: that cell's break + the skin's shift."""
    limit = patch.law.dynamic * load
    length = limit / patch.law.stiffness
    order = np.argsort(length)
    breaking = float(length[order][np.searchsorted(np.cumsum(load[order]), share * load.sum() * (1 - 1e-9))])
    strained = -np.expm1(-breaking / np.maximum(length, 1e-12))
    return breaking + float((limit * strained).sum()) / patch.stiffness


def skin_patch(
    friction: Friction, film: LayerMaterial | None, skin: InPlaneSkin, cells: Cells, grip: float
) -> SkinPatch:
    """The patch of skin under a contact's cells; `grip` scales both coefficients of friction.

    `film` is None where `skin` holds the film's shear already.

    The dampers of weave and skin are the same share of critical damping.
    """
    sigma0 = weave_stiffness(friction, film) * cells.area
    sigma1 = 2 * friction.loss_ratio * np.sqrt(sigma0.sum() * skin.mass_kg) * cells.area / cells.area.sum()
    law = LuGre(sigma0, sigma1, 0.0, grip * friction.static, grip * friction.dynamic, friction.stribeck_mm_s * 1e-3)
    damper = 2 * friction.loss_ratio * float(np.sqrt(skin.stiffness * skin.mass_kg))
    return SkinPatch(law, skin.mass_kg, skin.stiffness, damper)


def _drive(path: Path, cells: Cells, travel: float, rate: float) -> Array:
    """Velocity of the object at its cells: (1, 2) along a line, (n, 2) where it turns."""
    if not path.turns:
        return rate * np.array([[np.cos(path.direction), np.sin(path.direction)]])
    arm = path.to_sensor(cells.place, travel) - (path.x_m, path.y_m)
    return rate * np.stack((-arm[:, 1], arm[:, 0]), axis=1)


def _length(vectors: Array) -> Array:
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))


class _SlipWatch:
    """Which cells slip: at once when they come loose, until they have not slid for a while."""

    def __init__(self, friction: Friction, elements: int) -> None:
        self._slow = friction.slip_speed_mm_s * 1e-3
        self._held = friction.restick_ms * 1e-3 * FORCE_RATE_HZ
        self._last_loose = np.full(elements, -np.inf)

    def see(self, sample: int, speed: Array, utilisation: Array) -> NDArray[np.bool_]:
        """Cells (n,) that slip at `sample`, from their sliding speed (m/s) and utilisation (n,)."""
        self._last_loose[(utilisation > _BREAK) & (speed > self._slow)] = sample
        return np.asarray(sample - self._last_loose <= self._held)
