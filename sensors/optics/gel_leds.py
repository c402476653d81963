"""Coloured LEDs around a gel, by physics: Lambert and specular light of near sources, falloff, cast shadows.

For a gel sensor without real presses to calibrate on. Light of one LED on a facet of normal n at distance r, from the
direction l: power (r0 / r)^2 [albedo max(n . l, 0) + gloss max(n . h, 0)^shininess] seen, h halfway between l and the
camera (which looks along the normal of the flat membrane), r0 the distance of the frame's middle; `seen` falls from
1 to 0 as the horizon in the LED's direction rises through the LED's elevation.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from sensors.optics.horizon import horizon_elevation

Colour = tuple[float, float, float]


class Led(BaseModel):
    """A point source: azimuth from +x to +y, distance from the axis, height above the membrane, light per channel."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    azimuth_deg: float
    distance_mm: float = Field(26.0, gt=0)
    height_mm: float = Field(11.0, gt=0)
    colour: Colour = Field(description="light shed in red, green, blue; 1 on a white facet in the middle, facing it")

    @property
    def position_m(self) -> tuple[float, float, float]:
        """x, y, z in metres from the middle of the membrane; z is towards the camera."""
        azimuth = math.radians(self.azimuth_deg)
        flat = self.distance_mm * 1e-3
        return flat * math.cos(azimuth), flat * math.sin(azimuth), self.height_mm * 1e-3


class Membrane(BaseModel):
    """How the membrane reflects, and how soft shadows are."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    albedo: float = Field(0.8, gt=0, le=1)
    gloss: float = Field(0.10, ge=0, description="height of the specular lobe; 0 is a matt membrane")
    shininess: float = Field(12.0, ge=1)
    ambient: Colour = Field((0.08, 0.08, 0.08), description="light from everywhere, not shadowed")
    shadow_softness_deg: float = Field(4.0, gt=0, description="range of elevation over which an LED sets")
    shadow_reach_mm: float = Field(6.0, ge=0, description="longest shadow; 0 leaves shadows out")


class LedShader:
    """Light of LEDs on a frame of `shape` pixels of `pixel_m`; what the surface does not change is worked out once.

    Args:
        leds: the sources, at least one.
        membrane: reflection and shadows.
        shape: rows and columns.
        pixel_m: edge of a pixel on the membrane.
    """

    def __init__(self, leds: tuple[Led, ...], membrane: Membrane, shape: tuple[int, int], pixel_m: float) -> None:
        if not leds:
            raise ValueError("a gel needs at least one LED")
        self.leds, self.membrane, self.shape, self.pixel_m = leds, membrane, shape, pixel_m

    @cached_property
    def _towards(self) -> list[tuple[NDArray[np.float32], NDArray[np.float32]]]:
        """For each LED: unit vectors towards it (3, rows, columns) and its falloff (rows, columns)."""
        y, x = (((np.arange(n) + 0.5) - n / 2) * self.pixel_m for n in self.shape)
        found = []
        for led in self.leds:
            x_led, y_led, z_led = led.position_m
            across, down = np.meshgrid(x_led - x, y_led - y)
            distance = np.sqrt(across**2 + down**2 + z_led**2)
            falloff = (x_led**2 + y_led**2 + z_led**2) / distance**2
            unit = np.stack((across, down, np.full_like(across, z_led))) / distance
            found.append((unit.astype(np.float32), falloff.astype(np.float32)))
        return found

    def light(self, height_m: NDArray[np.floating]) -> NDArray[np.float32]:
        """Light (rows, columns, 3) off the membrane, 1 for the brightest flat white facet under one LED.

        `height_m` (rows, columns) is the displacement towards the camera in metres, one value a pixel.
        """
        if height_m.shape != self.shape:
            raise ValueError(f"height_m must have the frame's shape {self.shape}, got {height_m.shape}")
        height = np.asarray(height_m, np.float32) / np.float32(self.pixel_m)
        normal = _normals(height)
        total = np.empty((*self.shape, 3), np.float32)
        total[:] = np.asarray(self.membrane.ambient, np.float32) * np.float32(self.membrane.albedo)
        for led, (towards, falloff) in zip(self.leds, self._towards, strict=True):
            shed = self._reflected(normal, towards) * falloff
            if self.membrane.shadow_reach_mm > 0:
                shed = shed * self._seen(height, led, towards)
            total += shed[..., None] * np.asarray(led.colour, np.float32)
        return total

    def _reflected(self, normal: NDArray[np.float32], towards: NDArray[np.float32]) -> NDArray[np.float32]:
        m = self.membrane
        diffuse = m.albedo * np.maximum((normal * towards).sum(axis=0), 0)
        if m.gloss == 0:
            return diffuse
        halfway = towards + np.array([0, 0, 1], np.float32)[:, None, None]
        halfway /= np.sqrt((halfway**2).sum(axis=0))
        lobe = np.maximum((normal * halfway).sum(axis=0), 0) ** np.float32(m.shininess)
        return diffuse + m.gloss * lobe

    def _seen(self, height: NDArray[np.float32], led: Led, towards: NDArray[np.float32]) -> NDArray[np.float32]:
        """Share of the LED above the horizon, 0..1; the horizon is looked for in the LED's direction at the middle."""
        reach = self.membrane.shadow_reach_mm * 1e-3 / self.pixel_m
        horizon = horizon_elevation(height, math.radians(led.azimuth_deg), reach)
        clearance = np.arcsin(np.clip(towards[2], -1, 1)) - horizon
        return np.clip(0.5 + clearance / np.float32(math.radians(self.membrane.shadow_softness_deg)), 0, 1)


def _normals(height: NDArray[np.float32]) -> NDArray[np.float32]:
    """Unit normals (3, rows, columns) of a surface in pixels, towards the camera."""
    slope_y, slope_x = np.gradient(height)
    normal = np.stack((-slope_x, -slope_y, np.ones_like(height)))
    return normal / np.sqrt((normal**2).sum(axis=0))
