"""LuGre friction of many elements at once: bristles that stick, creep and slide, in one or two dimensions.

    z' = v - sigma0 |v| z / g(v)                  bristle deflection z (m)
    F  = sigma0 z + sigma1 z' + sigma2 v          force along v that the moving side must overcome (N)
    g  = Fc + (Fs - Fc) exp(-(|v| / vs)^2)        Fc = mu_d f_n, Fs = mu_s f_n

For a prescribed motion the bristle is advanced exactly for the midpoint velocity of the step; explicit Euler would need
dt < 2 g / (sigma0 |v|), which no recording rate satisfies for stiff bristles. Bristle and force are zero where the
normal force is zero. Where the load falls while nothing moves the bristle is cut back to what mu_s f_n can hold.

Source: C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A new model for control of systems with friction",
IEEE Trans. Automatic Control 40 (1995) 419-425. Passivity bound: the same storage function sigma0 |z|^2 / 2, with
sigma2 included; for sigma2 = 0 it is the bound sigma1 <= 4 g / |v| of N. Barabanov, R. Ortega, "Necessary and
sufficient conditions for passivity of the LuGre friction model", IEEE Trans. Automatic Control 45 (2000) 830-832.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.compiled import compiled

Array = NDArray[np.float64]

_IN_CACHE = 8000
"""Numbers in the largest temporary of `LuGre.follow`: larger ones cost more to allocate than to fill."""


@dataclass(frozen=True)
class LuGre:
    """One friction law; `stiffness` sigma0 (N/m), `damping` sigma1 and `viscosity` sigma2 (N s/m) may be per element.

    `static` mu_s >= `dynamic` mu_d > 0 are coefficients on the normal force, `stribeck_m_per_s` is vs.
    """

    stiffness: float | Array
    damping: float | Array = 0.0
    viscosity: float | Array = 0.0
    static: float = 0.6
    dynamic: float = 0.5
    stribeck_m_per_s: float = 5e-3

    def __post_init__(self) -> None:
        stiffness, damping, viscosity = map(np.asarray, (self.stiffness, self.damping, self.viscosity))
        if not np.all((stiffness > 0) & (stiffness < np.inf)):
            raise ValueError("LuGre needs a finite stiffness > 0 N/m in every element")
        if not all(np.all((sigma >= 0) & (sigma < np.inf)) for sigma in (damping, viscosity)):
            raise ValueError("LuGre needs finite damping >= 0 and viscosity >= 0 N s/m in every element")
        if not 0 < self.dynamic <= self.static < np.inf or not 0 < self.stribeck_m_per_s < np.inf:
            raise ValueError(
                "LuGre needs 0 < dynamic <= static and stribeck_m_per_s > 0, got "
                f"dynamic={self.dynamic}, static={self.static}, stribeck_m_per_s={self.stribeck_m_per_s}"
            )

    def coefficient(self, speed: Array) -> Array:
        """g / f_n at a sliding `speed` >= 0 (m/s): mu_s at rest, mu_d well above vs."""
        return self.dynamic + (self.static - self.dynamic) * np.exp(-((speed / self.stribeck_m_per_s) ** 2))

    def level(self, normal_force: Array, speed: Array) -> Array:
        """g (N), the size of the bristle force in steady sliding."""
        return normal_force * self.coefficient(speed)

    def steady_force(self, velocity: Array, normal_force: Array) -> Array:
        """Force (..., d) in steady sliding at `velocity` (..., d): g(v) along v, plus sigma2 v."""
        speed = _speed(velocity)
        along = velocity / np.where(speed > 0, speed, 1)[..., None]
        return (self.level(normal_force, speed)[..., None] * along + _column(self.viscosity) * velocity) * _loaded(
            normal_force
        )

    def rate(self, velocity: Array, normal_force: Array) -> Array:
        """a = sigma0 |v| / g (1/s), how fast bristles forget; 0 where there is no load."""
        speed = _speed(velocity)
        level = self.level(normal_force, speed)
        return np.divide(self.stiffness * speed, level, out=np.zeros(np.shape(level)), where=level > 0)

    def force(self, bristle: Array, velocity: Array, normal_force: Array) -> Array:
        """Force F (..., d; N) of bristles (..., d; m) at `velocity` (..., d; m/s) under `normal_force` (...; N)."""
        bristle_rate = velocity - self.rate(velocity, normal_force)[..., None] * bristle
        total = (
            _column(self.stiffness) * bristle
            + _column(self.damping) * bristle_rate
            + _column(self.viscosity) * velocity
        )
        return total * _loaded(normal_force)

    def hold(self, bristle: Array, normal_force: Array) -> Array:
        """The bristle (..., d) cut back to what the load can hold: |sigma0 z| <= mu_s f_n."""
        pull = self.stiffness * _speed(bristle)
        most = self.static * normal_force
        return bristle * np.divide(most, pull, out=np.ones(np.shape(pull)), where=pull > most)[..., None]

    def advance(
        self, bristle: Array, velocity: Array, next_velocity: Array, normal_force: Array, dt_s: float
    ) -> tuple[Array, Array]:
        """One step of prescribed motion from `velocity` to `next_velocity` (..., d); stable for every dt.

        Returns the bristle (..., d) and the force (..., d) at the end of the step. The solution is exact for the
        midpoint velocity, so the error is of second order in dt. Raises ValueError unless dt_s > 0.
        """
        if not dt_s > 0:
            raise ValueError(f"dt_s must be > 0, got {dt_s}")
        held = self.hold(bristle, normal_force)
        after = self.relax(held, 0.5 * (velocity + next_velocity), normal_force, dt_s)
        return after, self.force(after, next_velocity, normal_force)

    def follow(self, velocity: Array, normal_force: Array, dt_s: float) -> tuple[Array, Array]:
        """A whole prescribed motion from unstrained bristles: `advance` for every step, in one compiled pass.

        velocity (T, n, d; m/s) and normal_force (T, n; N) of n elements. Returns bristles (m) and forces (N), each
        (T, n, d), at every sample. Raises ValueError for other shapes, values that are not finite, or dt_s <= 0.
        """
        velocity, normal_force = np.asarray(velocity, dtype=np.float64), np.asarray(normal_force, dtype=np.float64)
        if velocity.ndim != 3 or velocity.shape[:2] != normal_force.shape or len(velocity) < 1:
            raise ValueError(
                "expected velocity (T, n, d) and normal_force (T, n) with T >= 1, "
                f"got {velocity.shape} and {normal_force.shape}"
            )
        if not dt_s > 0:
            raise ValueError(f"dt_s must be > 0, got {dt_s}")
        if not (np.isfinite(velocity).all() and np.isfinite(normal_force).all()):
            raise ValueError("expected finite velocity and normal_force, got NaN or infinity")
        bristle, force = np.zeros_like(velocity), np.empty_like(velocity)
        stiffness = np.broadcast_to(np.asarray(self.stiffness, dtype=np.float64), normal_force.shape[1:])
        steps = max(1, _IN_CACHE // max(1, velocity[0].size))
        for first in range(0, len(velocity), steps):
            # a stretch begins with the last sample of the one before
            part = slice(max(first - 1, 0), first + steps)
            middle, load = 0.5 * (velocity[part][:-1] + velocity[part][1:]), normal_force[part][1:]
            forgotten, reach = self.memory(middle, load, dt_s)
            _follow_bristles(bristle[part], stiffness, self.static * load, forgotten, middle * reach[..., None])
            force[part] = self.force(bristle[part], velocity[part], normal_force[part])
        return bristle, force

    def relax(self, bristle: Array, velocity: Array, normal_force: Array, dt_s: float) -> Array:
        """The bristle after `dt_s` at a constant velocity: z e^(-a dt) + v (1 - e^(-a dt)) / a."""
        forgotten, reach = self.memory(velocity, normal_force, dt_s)
        after = bristle - bristle * forgotten[..., None] + velocity * reach[..., None]
        return after * _loaded(normal_force)

    def memory(self, velocity: Array, normal_force: Array, dt_s: float) -> tuple[Array, Array]:
        """Share of a bristle forgotten in `dt_s`, 1 - e^(-a dt), and the time that it remembers, that over a (s)."""
        rate = self.rate(velocity, normal_force)
        forgotten = -np.expm1(-rate * dt_s)
        # (1 - e^(-a dt)) / a -> dt as a -> 0
        return forgotten, np.divide(forgotten, rate, out=np.full(np.shape(rate), dt_s), where=rate > 0)

    def passive_speed(self, normal_force: Array) -> Array:
        """Speed (m/s) up to which the element takes energy from its motion whatever the bristle's state.

        F.v - d/dt(sigma0 |z|^2 / 2) >= 0 while |v| <= 4 g (sigma1 + sigma2) / sigma1^2; here with the lowest g.
        """
        damping = np.asarray(self.damping, dtype=np.float64)
        least = 4 * self.dynamic * normal_force * (damping + self.viscosity)
        return np.divide(least, damping**2, out=np.full(np.broadcast(least, damping).shape, np.inf), where=damping > 0)


@compiled
def _follow_bristles(bristle: Array, stiffness: Array, most: Array, forgotten: Array, pulled: Array) -> None:
    """Fill bristle[1:] from bristle[0]."""
    steps, elements, axes = pulled.shape
    for t in range(steps):
        for i in range(elements):
            if most[t, i] <= 0:
                continue
            square = 0.0
            for axis in range(axes):
                square += bristle[t, i, axis] * bristle[t, i, axis]
            cut = 1.0
            # the root is the slow part, and few steps need it
            if stiffness[i] * stiffness[i] * square > most[t, i] * most[t, i] * (1 - 1e-12):
                cut = min(1.0, most[t, i] / (stiffness[i] * np.sqrt(square)))
            for axis in range(axes):
                held = bristle[t, i, axis] * cut
                bristle[t + 1, i, axis] = held - held * forgotten[t, i] + pulled[t, i, axis]


def _speed(velocity: Array) -> Array:
    return np.sqrt(np.einsum("...i,...i->...", velocity, velocity))


def _column(value: float | Array) -> Array:
    return np.asarray(value, dtype=np.float64)[..., None]


def _loaded(normal_force: Array) -> Array:
    return (np.asarray(normal_force) > 0)[..., None].astype(np.float64)
