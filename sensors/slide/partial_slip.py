"""The film on a plate under a moving object, cell by cell: what sticks, and the annulus that slips.

Instead of one patch that moves as a whole, the film's face moves as its own shear lets it (`LayerTangential`, under the
weave's crowns in series), and friction limits the traction at each cell of the contact grid (Cattaneo and Mindlin's
problem on a bonded layer). Solved at places along the motion, each from the one before, and interpolated along the way.

The pressure pattern is followed in the film's own coordinates: it stays where the object sticks and goes on where it
slips. Left out: inertia and LuGre's rise to static friction (Coulomb with the dynamic coefficient), so no stick-slip;
what shear does to the pressure (Goodman); turns of the object and vibration, which a scene refuses.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from sensors.contact.grid import Grid
from sensors.contact.solver import ContactSolution
from sensors.contact.tangential import LayerTangential
from sensors.contact.tangential_solver import TangentialSolution, solve_shift
from sensors.fvsight import FORCE_RATE_HZ
from sensors.slide.crowns import Crowns
from sensors.slide.drag import Drag, weave_stiffness
from sensors.slide.scene import Friction
from sensors.slide.track import Cells, Placed

Array = NDArray[np.float64]

_STEPS = 12
"""Places on the way from rest to gross slip."""
_REACH = 2.5
"""Ways to gross slip after which the places lie further apart: the contact slides steadily."""
_TOLERANCE = 1e-4
_STILL_M = 1e-12
"""What a sample without motion adds to the way."""


@dataclass(frozen=True)
class Sheared:
    """The sheared film at some places of a motion.

    clock (t,) of every sample and place (k,) on it: the way gone, and time where nothing `moves` (t,). At each place:
    face (k, 2, n, n; m) of the film's face, shift (k, 2; m) its mean over the load, pull (k, m, 2; N) and slip
    (k, m, 2; m) at each friction cell; on the way there slip_share (k,) of the load and stick_ratio (k,) of the area.
    """

    clock: Array
    place: Array
    moves: NDArray[np.bool_]
    face: NDArray[np.float32]
    shift: Array
    pull: Array
    slip: Array
    slip_share: Array
    stick_ratio: Array

    def face_at(self, sample: int) -> NDArray[np.float32]:
        """In-plane displacement (2, n, n; m) of the film's face at a sample."""
        at = float(np.interp(self.clock[sample], self.place, np.arange(len(self.place))))
        before = int(at)
        part = np.float32(at - before)
        return self.face[before] * (1 - part) + self.face[min(before + 1, len(self.face) - 1)] * part

    def drag(self, load: Array, crowns: Crowns | None) -> Drag:
        """The history of every sample under smooth cell loads (t, m)."""
        slip = self._every_sample(self.slip)
        carried = (
            load if crowns is None else np.stack([crowns.exchange(*pair) for pair in zip(load, slip, strict=True)])
        )
        share = load / np.maximum(load.sum(axis=1, keepdims=True), 1e-12)
        return Drag(
            self._every_sample(self.shift),
            carried - load,
            self._every_sample(self.pull),
            (share * np.hypot(slip[..., 0], slip[..., 1])).sum(axis=1),
            self._on_the_way(self.slip_share),
            self._on_the_way(self.stick_ratio),
        )

    def _on_the_way(self, values: Array) -> Array:
        """What holds of the way to a place holds of all of it where nothing moves."""
        coming = values[np.searchsorted(self.place, self.clock)]
        return np.where(self.moves, self._every_sample(values), coming)

    def _every_sample(self, values: Array) -> Array:
        flat = values.reshape(len(values), -1)
        out = np.stack([np.interp(self.clock, self.place, column) for column in flat.T], axis=-1)
        return out.reshape(len(self.clock), *values.shape[1:])


def shear_film(
    placed: Placed,
    friction: Friction,
    cells: Cells,
    travel: Array,
    load: Array,
    cell_load: Array,
    grip: float,
    presliding_m: float,
) -> Sheared:
    """Shear the film under `travel` (t,; m) and `load` (t,; N), shared out over `cells` as `cell_load` (t, m).

    `grip` scales the coefficient of friction, `presliding_m` is about how far the object moves until it slips. Raises
    what the contact solve raises.
    """
    unit, path = placed.unit, placed.path
    cover = 1 / weave_stiffness(friction, None)
    film = LayerTangential(unit.grid, unit.skin.film, np.float64, cover)
    along = np.array([np.cos(path.direction), np.sin(path.direction)])
    samples = solved_samples(travel, presliding_m / _STEPS, _REACH * presliding_m, unit.grid.pitch_m)
    origin = float(travel[0])
    steps: list[_Step] = []
    pressure, earlier = None, None
    for sample in samples:
        here = float(travel[sample])
        place, creep = here, 0.0
        if steps:
            last = steps[-1]
            # the pattern goes on over the film by what slips
            place = last.place + last.slip_share * (here - last.travel)
            creep = friction.slip_speed_mm_s * 1e-3 * (sample - last.sample) / FORCE_RATE_HZ
        contact = placed.solve(place, float(load[sample]), pressure)
        found = solve_shift(
            film,
            contact.pressure.astype(np.float64),
            grip * friction.dynamic,
            (here - origin) * along,
            before=earlier,
            tolerance=_TOLERANCE,
        )
        steps.append(_Step(int(sample), here, place, contact, found, earlier, creep, film.face(found.traction)))
        pressure, earlier = contact.pressure, found
    pulls = [step.pull(path.to_sensor(cells.place, step.place), cell_load[step.sample]) for step in steps]
    slips = [step.slip(path.to_sensor(cells.place, step.place)) for step in steps]
    stride = np.abs(np.diff(travel, prepend=travel[0]))
    clock = np.cumsum(stride) + _STILL_M * np.arange(len(travel))
    return Sheared(
        clock,
        clock[samples],
        stride > 0,
        np.stack([step.face for step in steps]).astype(np.float32),
        np.stack([step.shift for step in steps]),
        np.stack(pulls),
        np.stack(slips),
        np.array([step.slip_share for step in steps]),
        np.array([step.stick_ratio for step in steps]),
    )


def solved_samples(travel: Array, fine_m: float, reach_m: float, coarse_m: float) -> NDArray[np.intp]:
    """Samples at which to solve: first, last, those on both sides of a rest or turn, and some between.

    They lie `fine_m` of travel apart until `reach_m` from the last rest or turn, then `coarse_m`.
    """
    way = np.sign(np.diff(travel, prepend=travel[0]))
    turns = np.flatnonzero(np.diff(way))
    always = {*turns.tolist(), *(turns + 1).tolist(), len(travel) - 1}
    kept, origin = [0], float(travel[0])
    for i in range(1, len(travel)):
        near = abs(travel[i] - origin) <= reach_m
        if i in always or abs(travel[i] - travel[kept[-1]]) >= (fine_m if near else coarse_m):
            kept.append(i)
        if i in turns:
            origin = float(travel[i])
    return np.array(kept)


@dataclass(frozen=True)
class _Step:
    """One solved sample; `creep_m` is what a cell may slip since the step `earlier` and still count as sticking."""

    sample: int
    travel: float
    place: float
    contact: ContactSolution
    sheared: TangentialSolution
    earlier: TangentialSolution | None
    creep_m: float
    face: NDArray[np.floating]

    @cached_property
    def slides(self) -> NDArray[np.bool_]:
        """Cells (n, n) of the contact that slip."""
        if self.earlier is None:
            return np.zeros_like(self.contact.contact)
        moved = np.hypot(*(self.sheared.slip - self.earlier.slip))
        return np.asarray(self.sheared.slipping & (moved > self.creep_m))

    @cached_property
    def slip_share(self) -> float:
        """Of the load."""
        pressure = self.contact.pressure.astype(np.float64)
        return float(pressure[self.slides].sum() / max(pressure.sum(), 1e-12))

    @property
    def stick_ratio(self) -> float:
        """Share of the contact's area that sticks; one without contact."""
        touched = int(self.contact.contact.sum())
        return 1 - float(self.slides.sum()) / touched if touched else 1.0

    @property
    def shift(self) -> Array:
        """Mean over the load of the face's displacement, (2,) in metres."""
        pressure = self.contact.pressure.astype(np.float64)
        return np.asarray((self.face * pressure).sum(axis=(1, 2)) / max(float(pressure.sum()), 1e-12))

    def pull(self, points: Array, load: Array) -> Array:
        """Drag (m, 2; N) on the film at cells at `points` (m, 2) that carry `load` (m,); its sum is the film's."""
        limit = np.where(self.sheared.limit > 0, self.sheared.limit, 1.0)
        share = _sampled(self.sheared.traction / limit, self.contact.grid, points)
        pull = share * load[:, None]
        size = float(np.hypot(*pull.sum(axis=0)))
        return pull * (float(np.hypot(*self.sheared.force_n)) / size) if size > 0 else pull

    def slip(self, points: Array) -> Array:
        """How far (m, 2) the object has gone ahead of the weave at `points` (m, 2)."""
        return _sampled(self.sheared.slip, self.contact.grid, points)


def _sampled(field: NDArray[np.floating], grid: Grid, points: Array) -> Array:
    """Bilinear values (m, 2) of a field (2, n, n) at points (m, 2)."""
    at = ((points + grid.size_m / 2) / grid.pitch_m - 0.5).T[::-1]
    return np.stack(
        [map_coordinates(np.asarray(one, np.float64), at, order=1, mode="nearest") for one in field], axis=-1
    )
