"""FVSight: a skin of canvas over a 4x4 piezoresistive array, watched from inside by a camera.

Region, array, divider, supply, sampling rates and camera are the paper's ("A novel tactile sensor with multimodal
vision and tactile units for multifunctional robot interaction", Table I). Skin, LEDs and the spreads between
units are stated models: the paper gives none of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from sensors.contact.direct import solve_load_direct
from sensors.contact.grid import Grid
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.skin import SkinCompliance, SkinMaterial, sine_basis
from sensors.contact.solver import ContactSolution
from sensors.contact.thickness import refuse_through
from sensors.contact.winkler import WinklerBed, fit_winkler
from sensors.electronics.piezoresistive import PRESETS, PiezoresistiveChain, Preset
from sensors.electronics.scanning import Scanning
from sensors.optics.camera import Camera, CameraParameters, View
from sensors.optics.canvas import Canvas
from sensors.optics.lights import LedRing

TAXELS_PER_SIDE = 4
FORCE_RATE_HZ = 1000.0
FRAME_TOLERANCE = 3e-4
"""Of a contact too large for the direct solve; moves no pixel by 0.1 grey levels, no taxel by 0.01 N: below noise."""
_GUESS_CELLS = 64
"""Cells along a side of the coarsest grid on which a contact is looked for."""
_VARIANTS = ("taxels", "scanning", "dead_taxels", "creep", "contact")
_SPRING_FIT = (0.05, 0.1, 0.2, 0.3)
"""Depths over the film's thickness at which springs are fitted, under a ball of twice that radius."""
_UNIT_ENTROPY = 0x5F5349
"""A unit is the same physical sensor in every run: its traits depend on its number alone."""


class FVSightParameters(BaseModel):
    """What can be set on an FVSight; every length, force and angle carries its unit in its name."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    region_mm: float = Field(80.0, gt=0, le=500, description="side of the square sensing region")
    support: Literal["hollow", "plate"] = Field(
        "hollow",
        description="hollow: the skin spans the housing and the camera sees its inner face; plate: the film is bonded "
        "to a rigid window and the camera sees its touched face through it, as in gel sensors",
    )
    contact: Literal["elastic", "springs"] = Field(
        "elastic",
        description="elastic: the skin or the bonded layer; springs: independent ones in the layer's place (winkler), "
        "on a plate alone: cheap, good for the taxels' forces, wrong about the surface beside the contact",
    )
    tension_n_per_m: float = Field(600.0, gt=0, le=1e6, description="stretch of the skin over its frame")
    film_thickness_mm: float = Field(1.5, gt=0, le=200)
    film_modulus_mpa: float = Field(5.0, gt=0, le=1e6)
    film_poisson: float = Field(0.45, ge=0, le=0.5)
    grid: int = Field(128, ge=16, le=512, multiple_of=4, description="cells along a side of the contact grid")
    view: View = Field("region", description="what the camera stores: region, native_crop or full")
    stretching_bound: float = Field(
        0.15,
        gt=0,
        description="a press is refused where neglected stretching makes the deflection this much too large",
    )
    force_noise_mv: float = Field(1.0, ge=0, le=1000)
    hysteresis: bool = True
    creep: bool = Field(True, description="of a preset that creeps: false leaves its creep and overshoot out")
    camera_noise: bool = True
    tension_spread: float = Field(0.05, ge=0, le=0.5, description="standard deviation between units, relative")
    taxel_gain_spread: float = Field(0.03, ge=0, le=0.5, description="between taxels of a unit, relative conductance")
    unit_gain_spread: float = Field(0.02, ge=0, le=0.5, description="between units, relative conductance")
    led_power_spread: float = Field(0.08, ge=0, le=0.5, description="between the LEDs of all units, relative")
    led_azimuth_spread_deg: float = Field(3.0, ge=0, le=45)
    camera_offset_mm: float = Field(0.5, ge=0, le=10, description="between units, each axis")
    own_cloth: bool = Field(True, description="each unit has threads of its own")
    taxels: Preset = Field("fvsight", description="velostat: a bare sheet that creeps, overshoots and varies by press")
    scanning: Scanning = Field("isolated", description="what the rows that are not read do: ghosts where they float")
    dead_taxels: tuple[int, ...] = Field((), description="open circuits, by number from 0, row by row")
    session_gain_drift: float = Field(0.01, ge=0, le=0.5, description="between sessions, per taxel, relative force")
    session_offset_n: float = Field(0.02, ge=0, le=10, description="between sessions, per taxel, after taring")
    session_light_drift: float = Field(0.02, ge=0, le=0.5, description="between sessions, per colour channel, relative")

    @model_validator(mode="before")
    @classmethod
    def _keys_of_one_sensor(cls, value: Any) -> Any:
        if isinstance(value, cls | Mapping):
            return value
        raise ValueError(
            f"got {value!r}, but scenes simulate FVSight alone: its hollow skin (support: hollow) or a film on a plate "
            f"as in gel sensors (support: plate); expected a mapping of some of {', '.join(cls.model_fields)}"
        )

    @field_validator("dead_taxels")
    @classmethod
    def _taxels_exist(cls, numbers: tuple[int, ...]) -> tuple[int, ...]:
        if any(not 0 <= number < TAXELS_PER_SIDE**2 for number in numbers):
            raise ValueError(f"dead_taxels must lie in 0..{TAXELS_PER_SIDE**2 - 1}, got {list(numbers)}")
        return numbers

    @model_validator(mode="after")
    def _springs_stand_on_a_plate(self) -> FVSightParameters:
        if self.contact == "springs" and self.support != "plate":
            raise ValueError(
                "contact = 'springs' stands for a film on a plate; a hollow skin has one model: set support = 'plate'"
            )
        return self

    @model_serializer(mode="wrap")
    def _name_what_is_set(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Variants of the array appear where they are used, so that datasets without them keep their hashes."""
        fields = type(self).model_fields
        return {
            name: value
            for name, value in dump(self).items()
            if name not in _VARIANTS or getattr(self, name) != fields[name].default
        }

    @property
    def skin(self) -> SkinMaterial:
        """Nominal skin in SI units."""
        film = LayerMaterial(self.film_thickness_mm * 1e-3, self.film_modulus_mpa * 1e6, self.film_poisson)
        return SkinMaterial(film, self.tension_n_per_m)


@dataclass(frozen=True)
class Press:
    """One solved press: contact, sine modes of what the camera sees (m) and true taxel loads (16,) in newtons."""

    contact: ContactSolution
    surface_modes: NDArray[np.floating]
    taxel_load: NDArray[np.float64]


@dataclass(frozen=True)
class Session:
    """How one recording session differs from the unit's calibration."""

    gain: NDArray[np.float64]
    offset_n: NDArray[np.float64]
    light: NDArray[np.float64]


class FVSightUnit:
    """One physical sensor; `unit` picks its traits. Building it costs tens of milliseconds, a press a few: reuse it."""

    def __init__(self, parameters: FVSightParameters, unit: int) -> None:
        self.parameters = parameters
        self.unit = unit
        self.grid = Grid(parameters.grid, parameters.region_mm * 1e-3)
        traits = np.random.default_rng([_UNIT_ENTROPY, unit])
        skin = parameters.skin
        tension = skin.tension_n_per_m * (1 + parameters.tension_spread * traits.standard_normal())
        self.skin = replace(skin, tension_n_per_m=tension)
        unit_gain = parameters.unit_gain_spread * traits.standard_normal()
        taxel_gain = parameters.taxel_gain_spread * traits.standard_normal(TAXELS_PER_SIDE**2)
        self.taxel_gain = (1 + unit_gain) * (1 + taxel_gain)
        self._led_power = 1 + parameters.led_power_spread * traits.standard_normal(3)
        _refuse_dead(f"unit {unit}", "unit_gain_spread or taxel_gain_spread", np.append(self.taxel_gain, 1 + unit_gain))
        _refuse_dead(f"unit {unit}", "led_power_spread", self._led_power)
        self._led_turn = parameters.led_azimuth_spread_deg * traits.standard_normal(3)
        self._camera_offset = parameters.camera_offset_mm * 1e-3 * traits.standard_normal(2)
        self._cloth_rng = np.random.default_rng([_UNIT_ENTROPY, unit if parameters.own_cloth else 0, 1])
        self._tiles = self._tile_sums()

    @cached_property
    def compliance(self) -> SkinCompliance | LayerCompliance:
        """The contact rung of this unit, float32."""
        if self.parameters.support == "plate":
            return LayerCompliance(self.grid, self.skin.film, np.float32)
        return SkinCompliance(self.grid, self.skin, np.float32)

    @cached_property
    def levels(self) -> tuple[SkinCompliance | LayerCompliance, ...]:
        """The contact rung on grids that double from the first guess's to its own."""
        levels = [self.compliance]
        while levels[0].grid.n >= 2 * _GUESS_CELLS and levels[0].grid.n % 2 == 0:
            levels.insert(0, levels[0].coarser())
        return tuple(levels)

    @cached_property
    def springs(self) -> WinklerBed | None:
        """Springs in the place of the film on its plate, fitted under a ball; None where the film is elastic."""
        if self.parameters.contact == "elastic":
            return None
        thickness = self.skin.film.thickness_m
        x, y = self.grid.coordinates()
        ball = (x**2 + y**2) / (4 * thickness)
        return fit_winkler(self.skin.film, self.grid, ball, [ratio * thickness for ratio in _SPRING_FIT])

    @cached_property
    def camera(self) -> Camera:
        """The unit's camera with its own LEDs and cloth."""
        nominal = LedRing()
        first, second, third = (float(a + t) for a, t in zip(nominal.azimuths_deg, self._led_turn, strict=True))
        red, green, blue = (float(power) for power in self._led_power)
        leds = replace(nominal, azimuths_deg=(first, second, third), power=(red, green, blue))
        offset = (float(self._camera_offset[0]), float(self._camera_offset[1]))
        view = CameraParameters(view=self.parameters.view)
        return Camera(view, leds, Canvas(), self.grid.size_m, self.grid.n, self._cloth_rng, offset)

    @cached_property
    def chain(self) -> PiezoresistiveChain:
        """The electronics of the array."""
        p = self.parameters
        chain = replace(PRESETS[p.taxels], noise_v=p.force_noise_mv * 1e-3, scanning=p.scanning, rows=TAXELS_PER_SIDE)
        chain = chain if p.hysteresis else replace(chain, hysteresis=None)
        return chain if p.creep else replace(chain, creep=None)

    @cached_property
    def dead(self) -> NDArray[np.bool_] | None:
        """Which taxels (16,) are open circuits; None where all of them work."""
        numbers = list(self.parameters.dead_taxels)
        return np.isin(np.arange(TAXELS_PER_SIDE**2), numbers) if numbers else None

    def _tile_sums(self) -> NDArray[np.float32]:
        """(4, n) matrix that sums the cells of each taxel along one axis."""
        n = self.grid.n
        return np.kron(np.eye(TAXELS_PER_SIDE), np.ones(n // TAXELS_PER_SIDE)).astype(np.float32)

    def press(
        self,
        gap: NDArray[np.floating],
        load_n: float,
        initial: NDArray[np.floating] | None = None,
        tolerance: float = FRAME_TOLERANCE,
    ) -> Press:
        """Press an object of `gap` (n, n; metres, inf where there is none) with `load_n`; one contact solve.

        Raises ValueError where the skin would sink so far that its linear model is off by more than `stretching_bound`,
        or a film on a plate as far as it is thick.
        """
        return self.observe(self.solve(gap, load_n, initial, tolerance))

    def solve(
        self,
        gap: NDArray[np.floating],
        load_n: float,
        initial: NDArray[np.floating] | None = None,
        tolerance: float = FRAME_TOLERANCE,
    ) -> ContactSolution:
        """The contact alone; see `press`."""
        if self.springs is not None:
            contact = self.springs.solve_load(gap, load_n)
        else:
            contact = solve_load_direct(self.levels, gap, load_n, initial=initial, tolerance=tolerance)
        if self.parameters.support == "hollow":
            self._refuse_stretching(contact.indentation_m, load_n)
        else:
            refuse_through(contact, self.skin.film.thickness_m)
        return contact

    def observe(self, contact: ContactSolution) -> Press:
        """What camera and taxels get of a solved contact."""
        return Press(contact, self._surface_modes(contact.pressure), self.taxel_load(contact.pressure))

    def _surface_modes(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        if isinstance(self.compliance, SkinCompliance):
            return self.compliance.deflection_modes(pressure)
        basis = _grid_basis(self.grid.n)
        if self.springs is not None:
            return basis.T @ (pressure / self.springs.stiffness_pa_per_m) @ basis
        return basis.T @ self.compliance.displacement(pressure) @ basis

    def surface(self, modes: NDArray[np.floating]) -> NDArray[np.floating]:
        """Displacement (n, n) in metres of the surface that the camera sees."""
        basis = _grid_basis(self.grid.n)
        return basis @ modes @ basis.T

    def _refuse_stretching(self, indentation_m: float, load_n: float) -> None:
        error = self.skin.stretching_excess(indentation_m, self.grid.size_m / 2)
        if error > self.parameters.stretching_bound:
            raise ValueError(
                f"a press of {load_n:.3g} N sinks {indentation_m * 1e3:.2f} mm into the skin, where neglecting its "
                f"stretching is off by {error:.0%} (bound {self.parameters.stretching_bound:.0%}): "
                "lower the load or raise tension_n_per_m"
            )

    def taxel_load(self, pressure: NDArray[np.floating]) -> NDArray[np.float64]:
        """True load (N) on each of the 16 taxels, row by row: the film's base pressure over its tile."""
        base = self.compliance.base_pressure(pressure)
        tiles = self._tiles @ base @ self._tiles.T * self.grid.cell_area_m2
        return tiles.ravel().astype(np.float64)

    def session(self, rng: np.random.Generator | None) -> Session:
        """Draw a session's drift; None is a session without any. ValueError where a drift turns a factor over."""
        p, taxels = self.parameters, TAXELS_PER_SIDE**2
        if rng is None:
            return Session(np.ones(taxels), np.zeros(taxels), np.ones(3))
        drawn = Session(
            1 + p.session_gain_drift * rng.standard_normal(taxels),
            p.session_offset_n * rng.standard_normal(taxels),
            1 + p.session_light_drift * rng.standard_normal(3),
        )
        _refuse_dead(f"a session of unit {self.unit}", "session_gain_drift", drawn.gain)
        _refuse_dead(f"a session of unit {self.unit}", "session_light_drift", drawn.light)
        return drawn

    def read(self, load: NDArray[np.float64], session: Session, rng: np.random.Generator | None) -> NDArray[np.float32]:
        """Read-back forces (T, 16) in newtons for true taxel loads (T, 16)."""
        reading = self.chain.read(load, rng, self.taxel_gain, self.dead)
        return (reading * session.gain + session.offset_n).astype(np.float32)

    def frame(
        self,
        modes: NDArray[np.floating] | None,
        session: Session,
        rng: np.random.Generator | None,
        weave: NDArray[np.floating] | None = None,
    ) -> NDArray[np.uint8]:
        """A frame (rows, columns, 3) uint8 RGB of the surface with sine `modes`; None is the untouched skin.

        `weave` is what a drag in the plane does to the cloth, by `Camera.dragged_weave`.
        """
        return self.camera.capture(modes, rng if self.parameters.camera_noise else None, session.light, weave)


def _refuse_dead(whose: str, spread: str, factors: NDArray[np.float64]) -> None:
    """ValueError where a wide spread draws a factor <= 0: no taxel reads less where more is on it, no light is dark."""
    if not (factors > 0).all():
        raise ValueError(f"{whose} draws a factor of {factors.min():.2g}, which must be > 0: lower {spread}")


@lru_cache(maxsize=4)
def _grid_basis(n: int) -> NDArray[np.float32]:
    return sine_basis((np.arange(n) + 0.5) / n, n).astype(np.float32)


@lru_cache(maxsize=32)
def fvsight_unit(parameters: FVSightParameters, unit: int) -> FVSightUnit:
    """The unit with these parameters, built once per process."""
    return FVSightUnit(parameters, unit)
