"""The inner loop of `patch`, compiled: one step of the caller cut into substeps, element by element.

Slip scenes take it some 60,000 times a minute on a few dozen elements, where calling NumPy costs far more than the
arithmetic. IEEE arithmetic in a fixed order: the same machine gives the same bits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numba import njit

from sensors.friction.lugre import Array

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """`function` as machine code, kept beside the module or in the user's cache; where neither can be written, not."""
    try:
        return njit(cache=True, nogil=True)(function)
    except RuntimeError:  # no folder for the cache
        return njit(nogil=True)(function)


@compiled
def advance_elements(
    patch: Array,
    bristle: Array,
    slip: Array,
    drive: Array,
    next_drive: Array,
    normal_force: Array,
    sigmas: Array,
    law: tuple[float, float, float],
    carrier: tuple[float, float, float],
    step: tuple[int, float],
) -> tuple[Array, Array, Array, Array]:
    """Patch (4,; displacement and velocity), bristle, slip (m) and force (N) of the elements (n, 2) after a step.

    drive, next_drive (1 or n, 2; m/s); sigmas (3, n) are sigma0 to sigma2; law is mu_s, mu_d, vs (m/s); carrier is mass
    (kg), spring (N/m) and damper (N s/m) of the patch; step is the number of substeps and the length of each (s).
    """
    elements, shared = len(normal_force), len(drive) == 1
    count, h = step
    mass, spring, damper = carrier
    z, slid, force = bristle.copy(), slip.copy(), np.zeros_like(bristle)
    ux, uy, wx, wy = patch[0], patch[1], patch[2], patch[3]
    forgotten, reach = np.empty(elements), np.empty(elements)
    for i in range(elements):
        if normal_force[i] <= 0.0:
            z[i, 0] = z[i, 1] = 0.0
            continue
        pull, most = sigmas[0, i] * math.hypot(z[i, 0], z[i, 1]), law[0] * normal_force[i]
        if pull > most:  # the load has fallen: the bristle is cut back to what it can hold
            z[i, 0] *= most / pull
            z[i, 1] *= most / pull
        at = 0 if shared else i
        speed = math.hypot(drive[at, 0] - wx, drive[at, 1] - wy)
        forgotten[i], reach[i] = _memory(speed, sigmas[0, i], normal_force[i], law, h)
    for number in range(count):
        part = (number + 0.5) / count
        push_x, push_y, grip = -h * spring * ux, -h * spring * uy, 0.0
        for i in range(elements):
            if normal_force[i] > 0.0:
                at = 0 if shared else i
                hold = h * sigmas[0, i] - sigmas[1, i] * forgotten[i]
                drag = sigmas[1, i] * reach[i] + sigmas[2, i] * h
                push_x += hold * z[i, 0] + drag * (drive[at, 0] + (next_drive[at, 0] - drive[at, 0]) * part)
                push_y += hold * z[i, 1] + drag * (drive[at, 1] + (next_drive[at, 1] - drive[at, 1]) * part)
                grip += drag
        wx = (mass * wx + push_x) / (mass + h * damper + grip)
        wy = (mass * wy + push_y) / (mass + h * damper + grip)
        for i in range(elements):
            if normal_force[i] > 0.0:
                at = 0 if shared else i
                vx = drive[at, 0] + (next_drive[at, 0] - drive[at, 0]) * part - wx
                vy = drive[at, 1] + (next_drive[at, 1] - drive[at, 1]) * part - wy
                forgotten[i], reach[i] = _memory(math.hypot(vx, vy), sigmas[0, i], normal_force[i], law, h)
                dx, dy = reach[i] * vx - forgotten[i] * z[i, 0], reach[i] * vy - forgotten[i] * z[i, 1]
                z[i, 0] += dx
                z[i, 1] += dy
                slid[i, 0] += h * vx - dx
                slid[i, 1] += h * vy - dy
                force[i, 0] = sigmas[0, i] * z[i, 0] + sigmas[1, i] * dx / h + sigmas[2, i] * vx
                force[i, 1] = sigmas[0, i] * z[i, 1] + sigmas[1, i] * dy / h + sigmas[2, i] * vy
        ux += h * wx
        uy += h * wy
    return np.array((ux, uy, wx, wy)), z, slid, force


@compiled
def _memory(
    speed: float, sigma0: float, normal_force: float, law: tuple[float, float, float], h: float
) -> tuple[float, float]:
    """`LuGre.memory` of one loaded element."""
    mu_s, mu_d, stribeck = law
    level = normal_force * (mu_d + (mu_s - mu_d) * math.exp(-((speed / stribeck) ** 2)))
    rate = sigma0 * speed / level
    forgotten = -math.expm1(-rate * h)
    return forgotten, forgotten / rate if rate > 0.0 else h
