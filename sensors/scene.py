"""What happens in a scene, from its configuration to the plan of each sample."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from sensors import objects
from sensors.fvsight import FVSightParameters
from sensors.grids import GridChoice, choose_grid, refuse_deeper

_LATER = ("creep", "partial_slip")
"""Effects that came after the first datasets."""
_SHORTEST_S = 0.005
"""Of each part of a press: five samples of the forces."""


def _words_and_folders(text: str) -> str:
    """An id that can stand in paths, in a table's cell and before a sample's number."""
    if not re.fullmatch(r"[^\s/\\|.][^\s/\\|]*(/[^\s/\\|.][^\s/\\|]*)*", text):
        raise ValueError(
            "expected words joined by '/' without blanks, '|', or a dot in front of a word, such as "
            f"'my-presses/hard', got {text!r}"
        )
    return text


SceneId = Annotated[str, AfterValidator(_words_and_folders)]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Protocol(_Part):
    """How the samples are laid out: every round presses each object once, sessions hold whole rounds."""

    units: int = Field(6, ge=1, description="sensors, one after the other")
    rounds_per_unit: int = Field(12, ge=1)
    rounds_per_session: int = Field(3, ge=1)
    shallow_rounds: tuple[int, ...] = Field((5, 11), description="rounds of each unit that press lightly")

    @model_validator(mode="after")
    def _rounds_exist(self) -> Protocol:
        if any(not 0 <= number < self.rounds_per_unit for number in self.shallow_rounds):
            raise ValueError(
                f"shallow_rounds must lie in 0..{self.rounds_per_unit - 1}, got {list(self.shallow_rounds)}"
            )
        return self


class Load(_Part):
    """Force control: the load of a press in newtons and its relative spread from press to press."""

    deep_n: float = Field(5.0, gt=0, le=50)
    shallow_n: float = Field(1.5, gt=0, le=50)
    spread: float = Field(0.03, ge=0, le=0.3)


class Pose(_Part):
    """Where an object lies under the sensor: nominal pose, drawn once, plus what differs from press to press."""

    nominal_offset_mm: float = Field(
        0.0, ge=0, le=20, description="own place of each object: uniform within +- this, each axis"
    )
    nominal_turn_deg: float = Field(0.0, ge=0, le=180, description="own angle of each object: uniform within +- this")
    reseat_mm: float = Field(0.5, ge=0, le=20, description="re-seating error, standard deviation of each axis")
    reseat_deg: float = Field(1.0, ge=0, le=180, description="re-seating error, standard deviation")
    jitter_mm: float = Field(
        0.0, ge=0, le=20, description="unknown place: uniform within +- this at every press, each axis"
    )
    jitter_deg: float = Field(0.0, ge=0, le=180, description="unknown angle: uniform within +- this at every press")
    seed: int = Field(2024, ge=0, description="draws the nominal poses, whatever the run's seed")


class Effects(_Part):
    """Which variations run; what is off costs nothing."""

    unit_spread: bool = True
    session_drift: bool = True
    force_noise: bool = True
    camera_noise: bool = True
    hysteresis: bool = True
    creep: bool = Field(True, description="of taxels that creep; nothing else has any")

    @model_serializer(mode="wrap")
    def _name_what_is_set(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Later effects appear where they are switched, so that datasets without them keep their hashes."""
        fields = type(self).model_fields
        return {
            name: value
            for name, value in dump(self).items()
            if name not in _LATER or getattr(self, name) != fields[name].default
        }

    def on_sensor(self, sensor: FVSightParameters) -> FVSightParameters:
        """The sensor's parameters with the effects that are off set to nothing."""
        off: dict[str, Any] = {}
        if not self.unit_spread:
            off |= dict.fromkeys(
                (
                    "tension_spread",
                    "taxel_gain_spread",
                    "unit_gain_spread",
                    "led_power_spread",
                    "led_azimuth_spread_deg",
                    "camera_offset_mm",
                ),
                0.0,
            )
            off["own_cloth"] = False
        if not self.session_drift:
            off |= dict.fromkeys(("session_gain_drift", "session_offset_n", "session_light_drift"), 0.0)
        if not self.force_noise:
            off["force_noise_mv"] = 0.0
        if not self.camera_noise:
            off["camera_noise"] = False
        if not self.hysteresis:
            off["hysteresis"] = False
        if not self.creep:
            off["creep"] = False
        return sensor.model_copy(update=off)


class Motion(_Part):
    """The press in time: cosine approach, hold with the arm's ripple, cosine release."""

    approach_s: float = Field(0.35, ge=_SHORTEST_S, le=60)
    hold_s: float = Field(0.40, ge=_SHORTEST_S, le=60)
    release_s: float = Field(0.25, ge=_SHORTEST_S, le=60)
    ripple: float = Field(0.004, ge=0, le=0.5, description="amplitude of the arm's ripple on the load, relative")
    ripple_hz: float = Field(8.0, gt=0, le=500)


class ErrorBound(_Part):
    """How far readings may be off by contact model and grid; the cheapest that were measured to be within are taken.

    On a plate what a linear film leaves out at its depth (finite strain) counts too, and the frame takes no bound.
    """

    force: float | None = Field(None, gt=0, description="of each taxel, as a share of the load")
    displacement: float | None = Field(None, gt=0, description="of the surface that the camera sees, relative RMS")
    frame: float | None = Field(None, gt=0, description="RMS over the 256x256 frame in grey levels; hollow skins alone")

    @model_validator(mode="after")
    def _bounds_something(self) -> ErrorBound:
        if not self.named():
            raise ValueError("an error bound needs at least one of force, displacement and frame")
        return self

    def named(self) -> dict[str, float]:
        """The bounds that are set."""
        return {name: value for name, value in self if value is not None}


class PressScene(_Part):
    """A press scene: an FVSight pressed on household objects under force control."""

    id: SceneId
    title: str
    kind: Literal["press"] = "press"
    sensor: FVSightParameters = FVSightParameters()
    objects: tuple[str, ...] = Field((), description="names; empty means all 27")
    protocol: Protocol = Protocol()
    load: Load = Load()
    pose: Pose = Pose()
    motion: Motion = Motion()
    effects: Effects = Effects()
    specimen_mm: float = Field(
        56.0,
        gt=10,
        description="larger objects are cut to a disc of this diameter: a rigid body across the frame rests on its rim",
    )

    error_bound: ErrorBound | None = Field(
        None, description="chooses sensor.grid and sensor.contact; none: the sensor's own"
    )

    @model_serializer(mode="wrap")
    def _name_what_is_set(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """A bound appears where there is one, so that datasets without it keep their hashes."""
        return {name: value for name, value in dump(self).items() if name != "error_bound" or value is not None}

    @model_validator(mode="after")
    def _one_says_the_grid(self) -> PressScene:
        if self.error_bound is not None and self.sensor.grid != FVSightParameters().grid:
            raise ValueError("sensor.grid and error_bound both say which grid to take: leave one of the two")
        if self.error_bound is not None and self.sensor.contact != FVSightParameters().contact:
            raise ValueError("sensor.contact and error_bound both say which model to take: leave one of the two")
        return self

    @model_validator(mode="after")
    def _objects_exist(self) -> PressScene:
        for name in self.objects:
            objects.get(name)
        return self

    @model_validator(mode="after")
    def _some_grid_is_within(self) -> PressScene:
        self.grid_choice()
        return self

    @model_validator(mode="after")
    def _specimen_stays_inside(self) -> PressScene:
        reach = self.specimen_mm / 2 + self.pose.nominal_offset_mm + self.pose.jitter_mm + 4 * self.pose.reseat_mm
        if reach > self.sensor.region_mm / 2:
            raise ValueError(
                f"specimen_mm / 2 + nominal_offset_mm + jitter_mm + 4 reseat_mm = {reach:g} mm reaches the rim of the "
                f"{self.sensor.region_mm:g} mm region: lower one of them"
            )
        return self

    @property
    def object_names(self) -> tuple[str, ...]:
        """Objects in the order in which a round presses them."""
        return self.objects or objects.names()

    @property
    def n_samples(self) -> int:
        """Samples of the full protocol."""
        return len(self.object_names) * self.protocol.rounds_per_unit * self.protocol.units

    def grid_choice(self) -> GridChoice | None:
        """The cheapest contact model and grid that are measured to be within the error bound; None without a bound.

        Raises ValueError where no grid is, or nothing was measured for the sensor's pad, the objects or the loads.
        """
        if self.error_bound is None:
            return None
        return choose_grid(self.sensor.model_dump(), self.object_classes, self.loads_n, self.error_bound.named())

    def keep_bound(self, indentation_m: float) -> None:
        """ValueError where a press came so deep into a film on a plate that the error bound is broken."""
        if self.sensor.support == "hollow":
            return
        choice = self.grid_choice()
        if choice is not None and self.error_bound is not None:
            depth_ratio = indentation_m / (self.sensor.film_thickness_mm * 1e-3)
            refuse_deeper(choice, depth_ratio, self.sensor.film_poisson, self.error_bound.named())

    @property
    def object_classes(self) -> tuple[str, ...]:
        """Families of the objects."""
        return tuple(sorted({objects.get(name).family for name in self.object_names}))

    @property
    def loads_n(self) -> tuple[float, ...]:
        """Nominal loads of the presses."""
        shallow = (self.load.shallow_n,) if self.protocol.shallow_rounds else ()
        return (self.load.deep_n, *shallow)

    def effective_sensor(self) -> FVSightParameters:
        """The sensor's parameters on the grid that the bound asks for, with the effects that are off set to nothing."""
        choice = self.grid_choice()
        sensor = self.sensor if choice is None else self.sensor.model_copy(update=choice.taken)
        return self.effects.on_sensor(sensor)


@dataclass(frozen=True)
class SamplePlan:
    """What sample `index` of a scene shows, before any randomness but the nominal pose."""

    index: int
    object_name: str
    label: int
    unit: int
    session: int
    round: int
    press: Literal["deep", "shallow"]


def plan(scene: PressScene, index: int) -> SamplePlan:
    """Sample i shows object i mod n; every pass over the objects is a round, every 12 rounds the next unit."""
    if index < 0:
        raise ValueError(f"a sample index must be >= 0, got {index}")
    names, protocol = scene.object_names, scene.protocol
    total_round, position = divmod(index, len(names))
    unit, round_in_unit = divmod(total_round, protocol.rounds_per_unit)
    shallow = round_in_unit in protocol.shallow_rounds
    return SamplePlan(
        index=index,
        object_name=names[position],
        label=position,
        unit=unit,
        session=round_in_unit // protocol.rounds_per_session,
        round=round_in_unit,
        press="shallow" if shallow else "deep",
    )


def plans(scene: PressScene, samples: int) -> Iterator[SamplePlan]:
    """Plans of the first `samples` samples."""
    return (plan(scene, index) for index in range(samples))


def nominal_pose(pose: Pose, label: int) -> tuple[float, float, float]:
    """An object's own place and angle (mm, mm, deg), drawn once from the pose seed."""
    rng = np.random.default_rng([pose.seed, label])
    x, y, turn = rng.uniform(-1, 1, 3)
    return x * pose.nominal_offset_mm, y * pose.nominal_offset_mm, turn * pose.nominal_turn_deg
