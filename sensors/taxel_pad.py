"""Soft taxel pad: 14 x 6 taxels at 3.4 mm, one contact element each: ray, spring-damper that never pulls, LuGre.

Modelled after the soft contacts of S. Moisio, B. Leon, P. Korkealaakso, A. Morales, "Simulation of a tactile sensor
using soft contacts for robot grasping applications", with a Weiss DSA 9205 in mind: grid and pitch are that sensor's,
the 12 bits over 250 kPa and 240 frames a second are assumptions of its class, springs and friction are free parameters.
Elements do not feel their neighbours (no elastic coupling), and depth is measured along an element's own normal.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from sensors.friction.lugre import LuGre
from sensors.friction.pad import PadSpring
from sensors.solids import Ball, Solid
from sensors.taxel_layouts import Layout, fingertip_layout, flat_layout, spherical_layout
from sensors.touch import Touch

Array = NDArray[np.float64]

PressedSolid = Callable[[float], Solid]

FORCE_UNIT = "N"


class TaxelPadParameters(BaseModel):
    """What can be set on a pad; springs, dampers and bristles are those of one element."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    layout: Literal["flat", "sphere", "fingertip"] = "flat"
    rows: int = Field(14, ge=1)
    columns: int = Field(6, ge=1)
    pitch_mm: float = Field(3.4, gt=0)
    radius_mm: float = Field(20.0, gt=0, description="of the sphere and the fingertip")
    max_penetration_mm: float = Field(2.0, gt=0, description="length of an element's ray")
    stiffness_n_per_m: float = Field(300.0, gt=0)
    damping_ns_per_m: float = Field(0.3, ge=0)
    fade_mm: float = Field(0.05, gt=0, description="depth over which the damper fades in at touch")
    bristle_n_per_m: float = Field(1000.0, gt=0)
    bristle_damping_ns_per_m: float = Field(0.3, ge=0)
    static_friction: float = Field(0.7, gt=0)
    dynamic_friction: float = Field(0.6, gt=0)
    stribeck_mm_s: float = Field(5.0, gt=0)
    full_scale_kpa: float = Field(250.0, gt=0)
    bits: int = Field(12, ge=1, le=24)
    frame_rate_hz: float = Field(240.0, gt=0)


@dataclass(frozen=True)
class PadForces:
    """Forces on the pad's elements: normal (n,; N, >= 0), vectors (n, 3; N) in the pad's frame; bristles (n, 2; m)."""

    normal: Array
    vectors: Array
    bristle: Array


class TaxelPad:
    """One pad in its own frame: it faces +z, its middle is the origin; elements go row by row."""

    def __init__(self, parameters: TaxelPadParameters | None = None) -> None:
        self.parameters = p = parameters or TaxelPadParameters()
        self.spring = PadSpring(p.stiffness_n_per_m, p.damping_ns_per_m, p.fade_mm * 1e-3)
        self.friction = LuGre(
            p.bristle_n_per_m, p.bristle_damping_ns_per_m, 0.0,
            p.static_friction, p.dynamic_friction, p.stribeck_mm_s * 1e-3,
        )  # fmt: skip

    @cached_property
    def layout(self) -> Layout:
        """Points and normals of the elements."""
        p = self.parameters
        if p.layout == "flat":
            return flat_layout(p.rows, p.columns, p.pitch_mm * 1e-3)
        make = spherical_layout if p.layout == "sphere" else fingertip_layout
        return make(p.rows, p.columns, p.pitch_mm * 1e-3, p.radius_mm * 1e-3)

    def at_rest(self) -> Array:
        """Bristles (n, 2) that nothing strains."""
        return np.zeros((len(self.layout), 2))

    def depth(self, solid: Solid) -> Array:
        """How far (n,; m) a solid has come past each element, along rays of length `max_penetration_mm`; 0 outside.

        Raises ValueError where the solid has swallowed a whole ray: the pad is not that thick.
        """
        length, layout = self.parameters.max_penetration_mm * 1e-3, self.layout
        # the rays come from inside the pad, so that what they meet first is the side that presses
        entry = solid.entry(layout.points - length * layout.normals, layout.normals)
        if np.isnan(entry).any():
            raise ValueError("expected an object at a finite place, got NaN")
        if (entry <= 0).any():
            raise ValueError(
                f"the object is more than max_penetration_mm = {self.parameters.max_penetration_mm:g} mm deep in "
                f"{int((entry <= 0).sum())} of {len(layout)} elements: press less, or raise the limit or the stiffness"
            )
        return np.maximum(0, length - entry)

    def forces(self, bristle: Array, depth: Array, velocity: Array, dt_s: float) -> PadForces:
        """Forces after a step of `dt_s` in which the object moves past each element at `velocity`.

        bristle (n, 2; m) before the step, depth (n,; m), velocity (n, 3; m/s) of the object relative to the pad, in
        the pad's frame. The object gets the opposite of `vectors`. Raises ValueError unless dt_s > 0.
        """
        layout = self.layout
        normal = self.spring.force(depth, -np.einsum("ni,ni->n", velocity, layout.normals)) * (depth > 0)
        sliding = layout.tangential(velocity)
        after, shear = self.friction.advance(bristle, sliding, sliding, normal, dt_s)
        vectors = np.einsum("ni,nij->nj", shear, layout.tangents) - normal[:, None] * layout.normals
        return PadForces(normal, vectors, after)

    def press(self, make: PressedSolid, load_n: float) -> PadForces:
        """Lower a solid until the pad carries `load_n` along -z, at rest and without friction.

        `make(height_m)` is the solid with its lowest point at that height; it need not touch at 0. Raises ValueError
        for a load that is not > 0 or that the pad does not carry within its depth.
        """
        if not 0 < load_n < np.inf:
            raise ValueError(f"a press needs load_n > 0, got {load_n}")
        length = self.parameters.max_penetration_mm * 1e-3
        shallow, deep = 0.0, length * (1 - 1e-9)
        still = np.zeros((len(self.layout), 3))

        def at(sunk_m: float) -> PadForces:
            return self.forces(self.at_rest(), self.depth(make(-sunk_m)), still, 1.0)

        most = -float(at(deep).vectors[:, 2].sum())
        if most < load_n:
            raise ValueError(
                f"the pad carries {most:.3g} N of the {load_n:g} N at its full depth of {length * 1e3:g} mm: "
                "raise stiffness_n_per_m or max_penetration_mm"
            )
        for _ in range(_BISECTIONS):
            middle = (shallow + deep) / 2
            carried = -float(at(middle).vectors[:, 2].sum())
            shallow, deep = (middle, deep) if carried < load_n else (shallow, middle)
        return at(deep)

    def read(self, normal: Array, rate_hz: float | None = None) -> NDArray[np.float32]:
        """Frames (M, n) in newtons of normal forces (T, n; N) at `rate_hz`; a single instant (n,) without it.

        Each frame is the sample at its time, rounded to the converter's steps and cut at full scale. Raises ValueError
        for a rate below the pad's own.
        """
        p = self.parameters
        if rate_hz is not None:
            if rate_hz < p.frame_rate_hz:
                raise ValueError(f"forces must come at {p.frame_rate_hz:g} Hz or faster, got rate_hz={rate_hz:g}")
            normal = normal[np.arange(0, len(normal), rate_hz / p.frame_rate_hz).astype(int)]
        return (np.clip(np.rint(normal / self.step_n), 0, 2**p.bits - 1) * self.step_n).astype(np.float32)

    @property
    def step_n(self) -> float:
        """Newtons of one step of the converter: full scale over the taxel's area."""
        p = self.parameters
        return p.full_scale_kpa * 1e3 * (p.pitch_mm * 1e-3) ** 2 / (2**p.bits - 1)

    def image(self, normal: Array) -> NDArray[np.float32]:
        """One frame as the pad lies, (rows, columns) newtons."""
        return self.read(normal).reshape(self.parameters.rows, self.parameters.columns)


def sample_touch(load_n: float, rng: np.random.Generator) -> Touch:
    """A ball of 15 mm radius pressed on the flat pad, for the contract of sensors; the pad has no noise."""
    pad = TaxelPad()
    pressed = pad.press(lambda height: Ball((0.0, 0.0, height + 0.015), 0.015), load_n)
    series = np.repeat(pressed.normal[None], 10, axis=0)
    rate = pad.parameters.frame_rate_hz
    return Touch(-float(pressed.vectors[:, 2].sum()), pad.read(series, rate), rate, FORCE_UNIT)


_BISECTIONS = 48
"""Leaves nothing of a millimetre that a float would see."""
