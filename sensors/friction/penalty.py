"""Penalty contact of a tactile point: normal force from depth and its rate, shear force inside Coulomb's cone.

    f_n = max(0, (k_n + k_d d') d)           d > 0
    f_t = -v_t min(k_t, mu f_n / (|v_t| + eps))

Both are differentiable almost everywhere with finite gradients, at rest too, and are written in operators alone, so
that NumPy arrays and tensors of automatic differentiation pass through unchanged. There is no stick state: a body under
a steady shear load creeps at f / k_t. Use `lugre` where stick matters.

Source: the penalty model of J. Xu et al., "Efficient tactile simulation with differentiability for robotic
manipulation", CoRL 2022, f_t = min(k_t |v_t|, mu f_n) against the sliding; eps is ours and removes the 0 / 0 at rest.
"""

from __future__ import annotations

from typing import Any

_NO_SPEED = 1e-30
"""Added to |v|^2 (m^2/s^2) so that its root has a gradient at rest; far below the square of any speed that matters."""


def normal_force(depth: Any, depth_rate: Any, stiffness: float, damping: float) -> Any:
    """Normal force (N) at a penetration `depth` (m, >= 0 inside) that changes at `depth_rate` (m/s); never pulls.

    `stiffness` k_n in N/m, `damping` k_d in N s/m^2. Any matching shapes, NumPy or tensors.
    """
    push = (stiffness + damping * depth_rate) * depth
    return push * ((depth > 0) & (push > 0))


def shear_force(velocity: Any, normal: Any, stiffness: float, friction: float, eps: float = 1e-6) -> Any:
    """Shear force (..., d) in newtons on a point that moves at `velocity` (..., d; m/s) under `normal` (...; N).

    `stiffness` k_t in N s/m, `friction` mu, `eps` in m/s. Raises ValueError unless eps > 0, which keeps the gradient
    finite at rest.
    """
    if not eps > 0:
        raise ValueError(f"eps must be > 0 m/s to keep the gradient finite at rest, got {eps}")
    speed = ((velocity * velocity).sum(-1) + _NO_SPEED) ** 0.5
    cone = friction * normal / (speed + eps)
    sticks = cone >= stiffness
    gain = stiffness * sticks + cone * (~sticks)
    return -velocity * gain[..., None]
