"""What the arm does in one trial: travel of the object and load on it, sample by sample."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from sensors.fvsight import FORCE_RATE_HZ, TAXELS_PER_SIDE
from sensors.slide.scene import Kind, SlidePlan, SlipScene

Array = NDArray[np.float64]

_SPIN_UP_S = 0.02
"""Time in which a rotation reaches its rate."""
_MOVING_NOISE_HZ = 15.0


@dataclass(frozen=True)
class Script:
    """Travel (t,; metres, or radians of a rotation), load (t,; N) at 1 kHz, gain drift (t, 16) or None."""

    travel: Array
    load: Array
    gain: Array | None = None

    @property
    def moving(self) -> tuple[int, int] | None:
        """[first, last) sample of all lateral motion; None where there is none."""
        steps = np.flatnonzero(np.diff(self.travel))
        return (int(steps[0]), int(steps[-1]) + 2) if len(steps) else None


def write_script(
    scene: SlipScene, plan: SlidePlan, load_n: float, presliding_m: float, seed_rng: np.random.Generator
) -> Script:
    """The trial's script; `presliding_m` is how far the object can move before it slips (incipient trials)."""
    return _KINDS[plan.kind](_Stage(scene, plan, load_n, presliding_m, seed_rng))


@dataclass(frozen=True)
class _Stage:
    """All that a kind of trial may look at."""

    scene: SlipScene
    plan: SlidePlan
    load_n: float
    presliding_m: float
    rng: np.random.Generator

    def between(self, bounds: tuple[float, float]) -> float:
        return float(self.rng.uniform(*bounds))

    def samples(self, sliding: bool) -> int:
        motion = self.scene.motion
        return round((motion.sliding_s if sliding else motion.negative_s) * FORCE_RATE_HZ)

    def rippled(self, profile: Array) -> Array:
        """Load (t,) for a relative profile (t,), with the arm's ripple."""
        motion = self.scene.motion
        phase = 2 * np.pi * (motion.ripple_hz * _clock(len(profile)) + self.rng.random())
        return self.load_n * profile * (1 + motion.load_ripple * np.sin(phase))


def _clock(samples: int) -> Array:
    return np.arange(samples) / FORCE_RATE_HZ


def travel_profile(distance: float, speed: float, acceleration: float) -> Array:
    """Travel at 1 kHz over one motion from rest to rest: trapezoid of speed, or a triangle where it is too short."""
    speed = min(speed, float(np.sqrt(distance * acceleration)))
    ramp = speed / acceleration
    total = distance / speed + ramp
    t = np.minimum(_clock(int(np.ceil(total * FORCE_RATE_HZ)) + 1), total)
    braking = distance - 0.5 * acceleration * (total - t) ** 2
    return np.where(t < ramp, 0.5 * acceleration * t**2, np.where(t > total - ramp, braking, speed * (t - ramp / 2)))


def _placed(samples: int, start: int, *parts: Array) -> Array:
    """Travel (samples,) that rests at zero, goes through `parts` from `start`, and stays at the end."""
    way = np.concatenate((np.zeros(start), *parts))
    return np.concatenate((way, np.full(max(samples - len(way), 0), way[-1])))[:samples]


def _start(stage: _Stage) -> int:
    motion = stage.scene.motion
    return round((motion.rest_s + motion.rest_jitter_s * stage.rng.uniform(-1, 1)) * FORCE_RATE_HZ)


def _moved(stage: _Stage, distance: float, speed: float, acceleration: float) -> Script:
    samples, start = stage.samples(sliding=True), _start(stage)
    way = travel_profile(distance, abs(speed), acceleration)
    travel = _placed(samples, start, np.sign(speed) * way)
    load = stage.rippled(np.ones(samples))
    # white noise through one pole, scaled back to unit variance: the force controller while the arm moves
    pole = np.exp(-2 * np.pi * _MOVING_NOISE_HZ / FORCE_RATE_HZ)
    noise = lfilter([np.sqrt(1 - pole**2)], [1, -pole], stage.rng.standard_normal(len(way)))
    fade = np.minimum(1, np.minimum(np.arange(len(way)), np.arange(len(way))[::-1]) / 50)
    stop = min(start + len(way), samples)
    load[start:stop] *= 1 + stage.scene.motion.moving_noise * (noise * fade)[: stop - start]
    return Script(travel, load)


def _slide(stage: _Stage) -> Script:
    motion, speed = stage.scene.motion, stage.plan.speed_mm_s * 1e-3
    distance = min(speed * motion.move_s, motion.longest_mm * 1e-3)
    return _moved(stage, distance, speed, motion.acceleration_m_s2)


def _rotation(stage: _Stage) -> Script:
    rate = float(np.deg2rad(stage.plan.rotation_deg_s))
    return _moved(stage, abs(rate) * stage.scene.motion.move_s, rate, abs(rate) / _SPIN_UP_S)


def _incipient(stage: _Stage) -> Script:
    """Forth by a share of the presliding distance, a pause, and back."""
    samples, start, motion = stage.samples(sliding=True), _start(stage), stage.scene.motion
    distance = stage.between(stage.scene.disturbances.incipient_shares) * stage.presliding_m
    forth = travel_profile(distance, stage.plan.speed_mm_s * 1e-3, motion.acceleration_m_s2)
    pause = np.full(round(stage.between((0.2, 0.4)) * FORCE_RATE_HZ), distance)
    travel = _placed(samples, start, forth, pause, distance - forth)
    return Script(travel, stage.rippled(np.ones(samples)))


def _ramp(samples: int, low: float, high: float) -> Array:
    part = 0.5 - 0.5 * np.cos(np.pi * (np.arange(samples) + 1) / samples)
    return low + (high - low) * part


def _segments(samples: int, parts: list[Array]) -> Array:
    return np.concatenate(parts)[:samples]


def _load_change(stage: _Stage) -> Script:
    samples, chosen = stage.samples(sliding=False), stage.scene.disturbances
    level, parts, length = 1.0, [np.ones(round(0.4 * FORCE_RATE_HZ))], 0
    while length < samples:
        goal = stage.between(chosen.load_range)
        parts.append(_ramp(round(stage.between(chosen.load_ramp_s) * FORCE_RATE_HZ), level, goal))
        parts.append(np.full(round(stage.between((0.2, 0.6)) * FORCE_RATE_HZ), goal))
        level, length = goal, sum(map(len, parts))
    return Script(np.zeros(samples), stage.rippled(_segments(samples, parts)))


def _tapping(stage: _Stage) -> Script:
    samples, chosen = stage.samples(sliding=False), stage.scene.disturbances
    parts, length = [np.zeros(round(0.3 * FORCE_RATE_HZ))], 0
    while length < samples:
        width = round(stage.between(chosen.tap_s) * FORCE_RATE_HZ)
        parts.append(stage.between(chosen.tap_range) * np.sin(np.pi * (np.arange(width) + 1) / (width + 1)) ** 2)
        parts.append(np.zeros(round(stage.between(chosen.tap_pause_s) * FORCE_RATE_HZ)))
        length = sum(map(len, parts))
    return Script(np.zeros(samples), stage.rippled(_segments(samples, parts)))


def _arm_vibration(stage: _Stage) -> Script:
    """The arm shakes the load and, by less than the skin gives, the object's place, at one frequency."""
    samples, chosen = stage.samples(sliding=False), stage.scene.disturbances
    t, hertz = _clock(samples), stage.between(chosen.vibration_hz)
    fade = np.clip((t - 0.4) / 0.3, 0, 1) * np.clip((t[-1] - t) / 0.3, 0, 1)
    lateral, pressing = stage.rng.uniform(0, 2 * np.pi, 2)
    travel = stage.between(chosen.vibration_um) * 1e-6 * fade * np.sin(2 * np.pi * hertz * t + lateral)
    profile = 1 + stage.between(chosen.vibration_load) * fade * np.sin(2 * np.pi * hertz * t + pressing)
    return Script(travel, stage.rippled(profile))


def _drift(stage: _Stage) -> Script:
    samples, chosen = stage.samples(sliding=False), stage.scene.disturbances
    t = _clock(samples)
    waves = [np.sin(2 * np.pi * (t / stage.between((2.0, 8.0)) + stage.rng.random())) for _ in range(2)]
    warming = chosen.drift_gain * stage.rng.standard_normal(TAXELS_PER_SIDE**2)
    gain = 1 + warming * (t / t[-1])[:, None]
    return Script(np.zeros(samples), stage.rippled(1 - chosen.drift_load * (0.5 + 0.25 * (waves[0] + waves[1]))), gain)


def _recovery(stage: _Stage) -> Script:
    """Held, released to a small rest of the load, pressed again."""
    samples, chosen = stage.samples(sliding=False), stage.scene.disturbances
    parts: list[Array] = []
    while sum(map(len, parts)) < samples:
        residual = stage.between(chosen.residual_range)
        parts.append(np.ones(round(stage.between((0.8, 1.2)) * FORCE_RATE_HZ)))
        parts.append(_ramp(round(stage.between((0.05, 0.25)) * FORCE_RATE_HZ), 1.0, residual))
        parts.append(np.full(round(stage.between((1.2, 1.8)) * FORCE_RATE_HZ), residual))
        parts.append(_ramp(round(stage.between((0.2, 0.4)) * FORCE_RATE_HZ), residual, 1.0))
    return Script(np.zeros(samples), stage.rippled(_segments(samples, parts)))


_KINDS: dict[Kind, Callable[[_Stage], Script]] = {
    "slide": _slide,
    "rotation": _rotation,
    "incipient": _incipient,
    "load_change": _load_change,
    "tapping": _tapping,
    "arm_vibration": _arm_vibration,
    "drift": _drift,
    "recovery": _recovery,
}
