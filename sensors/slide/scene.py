"""What happens in a slip scene, from its configuration to the plan of each trial."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, model_validator

from sensors.fvsight import FVSightParameters
from sensors.scene import Effects, SceneId
from sensors.slide.shapes import BODIES, body

Kind = Literal["slide", "rotation", "incipient", "load_change", "tapping", "arm_vibration", "drift", "recovery"]
KINDS: tuple[Kind, ...] = get_args(Kind)
SLIPPING: tuple[Kind, ...] = ("slide", "rotation")
"""Kinds of trial that are meant to end in gross slip; every other kind is a negative."""

UNSHEARED: tuple[Kind, ...] = ("rotation", "arm_vibration")
"""Kinds of trial that partial slip is not worked out for."""


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class SlipProtocol(_Part):
    """How trials are laid out: each pass shows every object once, in one kind of trial."""

    kinds: tuple[Kind, ...] = Field(("slide",), min_length=1)
    trials: int = Field(20, ge=1, description="of each kind with each object")
    units: int = Field(1, ge=1, description="sensors, the trials of a kind in equal blocks")
    trials_per_session: int = Field(5, ge=1)

    @model_validator(mode="after")
    def _each_kind_once(self) -> SlipProtocol:
        if len(set(self.kinds)) < len(self.kinds):
            raise ValueError(f"each kind may be listed once, got {list(self.kinds)}")
        return self


class Conditions(_Part):
    """Lists that the trials cycle through; lists of coprime lengths meet in every combination."""

    speeds_mm_s: tuple[float, ...] = Field((10.0,), min_length=1, description="of the lateral motion")
    loads_n: tuple[float, ...] = Field((5.0,), min_length=1)
    directions_deg: tuple[float, ...] = Field((0.0,), min_length=1, description="0 is along the rows of taxels")
    rotations_deg_s: tuple[float, ...] = Field((60.0, -60.0), min_length=1, description="of the rotation trials")
    load_spread: float = Field(0.01, ge=0, le=0.3, description="from trial to trial, relative standard deviation")

    @model_validator(mode="after")
    def _possible(self) -> Conditions:
        if min(self.speeds_mm_s) <= 0 or max(self.speeds_mm_s) > 200:
            raise ValueError(f"speeds_mm_s must lie in (0, 200], got {list(self.speeds_mm_s)}")
        if min(self.loads_n) <= 0 or max(self.loads_n) > 50:
            raise ValueError(f"loads_n must lie in (0, 50], got {list(self.loads_n)}")
        if 0 in self.rotations_deg_s or max(map(abs, self.rotations_deg_s)) > 720:
            raise ValueError(f"rotations_deg_s must be non-zero and within +- 720, got {list(self.rotations_deg_s)}")
        return self


class Placing(_Part):
    """How the object lies under the sensor at the start of a trial."""

    offset_mm: float = Field(1.0, ge=0, le=10, description="uniform within +- this, each axis")
    turn_deg: float = Field(2.0, ge=0, le=180, description="uniform within +- this")
    tilt_deg: float = Field(0.2, ge=0, le=2, description="between object and skin, standard deviation, each axis")


class SlipMotion(_Part):
    """The arm in time: rest, motion at a fixed speed, rest."""

    rest_s: float = Field(1.0, ge=0.05, le=60)
    rest_jitter_s: float = Field(0.2, ge=0, le=10, description="start of the motion: uniform within +- this")
    move_s: float = Field(1.2, ge=0.005, le=60, description="longest motion")
    settle_s: float = Field(0.8, ge=0.2, le=60, description="rest after the longest motion")
    longest_mm: float = Field(12.0, gt=0, le=20, description="a faster motion ends here")
    acceleration_m_s2: float = Field(0.5, gt=0, description="of the arm; assumption")
    negative_s: float = Field(3.0, ge=2, le=600, description="length of the trials without lateral motion")
    load_ripple: float = Field(0.004, ge=0, le=0.2, description="amplitude of the arm's ripple on the load, relative")
    ripple_hz: float = Field(8.0, gt=0, le=400)
    moving_noise: float = Field(0.005, ge=0, le=0.2, description="force control while moving, relative std, 15 Hz")

    @model_validator(mode="after")
    def _starts_after_zero(self) -> SlipMotion:
        if self.rest_jitter_s > 0.8 * self.rest_s or self.rest_jitter_s > self.settle_s - 0.2:
            raise ValueError(
                f"rest_jitter_s = {self.rest_jitter_s:g} s does not fit into rest_s = {self.rest_s:g} s and "
                f"settle_s = {self.settle_s:g} s"
            )
        return self

    @property
    def sliding_s(self) -> float:
        """Length of a trial with lateral motion."""
        return self.rest_s + self.move_s + self.settle_s


class Friction(_Part):
    """LuGre friction of linen on the object, and what carries it; textile figures are assumptions of usual size."""

    static: float = Field(0.6, gt=0, le=2)
    dynamic: float = Field(0.5, gt=0, le=2)
    spread: float = Field(0.05, ge=0, le=0.3, description="both coefficients from trial to trial, relative std")
    stribeck_mm_s: float = Field(5.0, gt=0)
    weave_mpa_per_mm: float = Field(0.3, gt=0, description="shear stress that shifts the crowns of the weave by a mm")
    loss_ratio: float = Field(0.1, gt=0, lt=1, description="damping ratio of weave and skin at their resonance")
    areal_mass_kg_m2: float = Field(
        1.85, ge=1e-3, le=1e3, description="film (1.5 mm, 1100 kg/m3) and canvas (0.2 kg/m2)"
    )
    partial_share: float = Field(0.05, gt=0, lt=1, description="partial slip: this share of the load slips")
    gross_share: float = Field(0.9, gt=0, le=1, description="gross slip: this share of the load slips")
    slip_speed_mm_s: float = Field(0.1, gt=0, description="slower is creep")
    restick_ms: float = Field(10.0, ge=0, description="a cell sticks again after this long without slip")

    @model_validator(mode="after")
    def _ordered(self) -> Friction:
        if self.dynamic > self.static:
            raise ValueError(f"dynamic = {self.dynamic:g} must not exceed static = {self.static:g}")
        if self.partial_share >= self.gross_share:
            raise ValueError(
                f"partial_share = {self.partial_share:g} must lie below gross_share = {self.gross_share:g}"
            )
        return self


class Film(_Part):
    """Delayed recovery of the taxel film: a share of every change of load arrives late."""

    late_share: float = Field(0.05, ge=0, lt=1)
    late_s: float = Field(0.35, gt=0, description="time constant; the public Velostat recordings show 0.26..0.46 s")


class Disturbances(_Part):
    """How strong the negatives are, as shares of the trial's load unless a unit is named."""

    incipient_shares: tuple[float, float] = Field((0.3, 0.6), description="of the presliding distance")
    load_range: tuple[float, float] = Field((0.4, 1.1), description="levels of the load changes")
    load_ramp_s: tuple[float, float] = (0.05, 0.3)
    tap_range: tuple[float, float] = (0.2, 1.0)
    tap_s: tuple[float, float] = (0.03, 0.08)
    tap_pause_s: tuple[float, float] = (0.15, 0.45)
    vibration_hz: tuple[float, float] = (10.0, 80.0)
    vibration_load: tuple[float, float] = (0.01, 0.05)
    vibration_um: tuple[float, float] = Field((2.0, 20.0), description="lateral amplitude, micrometres")
    drift_load: float = Field(0.15, ge=0, lt=1)
    drift_gain: float = Field(0.03, ge=0, le=0.3, description="warming of each taxel over the trial, std, relative")
    residual_range: tuple[float, float] = Field((0.0, 0.2), description="load left after a release")

    @model_validator(mode="after")
    def _ranges_rise(self) -> Disturbances:
        for name, value in self:
            if isinstance(value, tuple) and not 0 <= value[0] <= value[1]:
                raise ValueError(f"{name} must be a rising pair of numbers >= 0, got {list(value)}")
        return self


class SlideEffects(Effects):
    """Which variations run; what is off costs nothing."""

    crowns: bool = Field(True, description="thread crowns exchange load as the object rides over them")
    shear_moment: bool = Field(True, description="shear on the film's face loads the taxels ahead of it")
    late_film: bool = True
    partial_slip: bool = Field(
        False, description="a film on a plate shears and slips cell by cell; off: as one patch that friction drags"
    )


class SlipScene(_Part):
    """A slip scene: an FVSight pressed on an object, moved sideways or disturbed."""

    id: SceneId
    title: str
    kind: Literal["slide"] = "slide"
    sensor: FVSightParameters = FVSightParameters()
    objects: tuple[str, ...] = Field(tuple(BODIES), min_length=1)
    protocol: SlipProtocol = SlipProtocol()
    conditions: Conditions = Conditions()
    placing: Placing = Placing()
    motion: SlipMotion = SlipMotion()
    friction: Friction = Friction()
    film: Film = Film()
    disturbances: Disturbances = Disturbances()
    effects: SlideEffects = SlideEffects()

    @model_validator(mode="after")
    def _objects_exist(self) -> SlipScene:
        for name in self.objects:
            body(name)
        return self

    @model_validator(mode="after")
    def _partial_slip_is_known(self) -> SlipScene:
        if not self.effects.partial_slip:
            return self
        if self.sensor.support != "plate":
            raise ValueError(
                "effects.partial_slip shears a film that is bonded to a plate, got sensor.support = "
                f"{self.sensor.support!r}: set 'plate' or leave the effect off"
            )
        if others := [kind for kind in self.protocol.kinds if kind in UNSHEARED]:
            raise ValueError(
                f"effects.partial_slip moves the object along a line and slowly, got kinds {others}: "
                "leave them out or the effect off"
            )
        return self

    @property
    def object_names(self) -> tuple[str, ...]:
        """Objects in the order in which a pass shows them."""
        return self.objects

    @property
    def n_samples(self) -> int:
        """Trials of the full protocol."""
        return len(self.objects) * len(self.protocol.kinds) * self.protocol.trials

    def effective_sensor(self) -> FVSightParameters:
        """The sensor's parameters with the effects that are off set to nothing."""
        return self.effects.on_sensor(self.sensor)

    def plan(self, index: int) -> SlidePlan:
        """Trial i shows object i mod n; every pass over the objects is the next kind, every cycle the next trial.

        Raises ValueError for a negative index.
        """
        if index < 0:
            raise ValueError(f"a trial index must be >= 0, got {index}")
        passed, position = divmod(index, len(self.objects))
        trial, kind = divmod(passed, len(self.protocol.kinds))
        protocol, conditions = self.protocol, self.conditions

        def cycled(values: tuple[float, ...]) -> float:
            return values[trial % len(values)]

        kind_name = protocol.kinds[kind]
        moves = kind_name in ("slide", "incipient")
        return SlidePlan(
            index=index,
            object_name=self.objects[position],
            kind=kind_name,
            trial=trial,
            unit=trial * protocol.units // protocol.trials,
            session=trial // protocol.trials_per_session,
            speed_mm_s=cycled(conditions.speeds_mm_s) if moves else 0.0,
            load_n=cycled(conditions.loads_n),
            direction_deg=cycled(conditions.directions_deg),
            rotation_deg_s=cycled(conditions.rotations_deg_s) if kind_name == "rotation" else 0.0,
        )


@dataclass(frozen=True)
class SlidePlan:
    """What trial `index` of a scene does, before any randomness."""

    index: int
    object_name: str
    kind: Kind
    trial: int
    unit: int
    session: int
    speed_mm_s: float
    load_n: float
    direction_deg: float
    rotation_deg_s: float

    def labels(self, seed: int) -> dict[str, Any]:
        """What a data set stores beside the trial's arrays."""
        return {
            "id": f"{self.index:06d}",
            "object": self.object_name,
            "kind": self.kind,
            "trial": self.trial,
            "unit": self.unit,
            "session": self.session,
            "speed_mm_s": self.speed_mm_s,
            "rotation_deg_s": self.rotation_deg_s,
            "load_n": self.load_n,
            "direction_deg": self.direction_deg,
            "seed": seed,
        }
