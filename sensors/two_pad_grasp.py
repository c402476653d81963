"""A cube lifted by a parallel gripper with a taxel pad on each finger, whose grip is fed by the pads alone.

The cube translates in space and does not turn; the fingers are driven in velocity and have no mass of their own. World
axes: x closes the gripper, z is up. The table is a spring-damper under the cube.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.friction.body import count_substeps
from sensors.solids import Box
from sensors.taxel_pad import TaxelPad

Array = NDArray[np.float64]

GRAVITY = np.array([0.0, 0.0, -9.81])
_LEFT = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
_RIGHT = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Columns are the axes of a pad's frame in the world's: the pads face each other, their rows run upwards."""
_TABLE_N_PER_M = 2e4
_TABLE_NS_PER_M = 40.0


@dataclass(frozen=True)
class Grasp:
    """The task: cube and how far from the middle it stands, wanted grip, lift, controller, step of the simulation.

    The controller closes the fingers at `gain_m_per_ns` times the missing force, at most at `close_mm_s`.
    """

    mass_kg: float = 0.2
    edge_mm: float = 30.0
    offset_mm: float = 0.3
    grip_n: float = 8.0
    lift_at_s: float = 0.8
    lift_mm: float = 20.0
    lift_mm_s: float = 40.0
    duration_s: float = 1.8
    close_mm_s: float = 5.0
    gain_m_per_ns: float = 1e-3
    dt_s: float = 1e-3


@dataclass(frozen=True)
class GraspHistory:
    """What happened, at every step (T, ...): positions and velocities of the cube (3; m, m/s), forces in newtons.

    on_left, on_right   force vectors (T, 3) on the pads
    on_cube             force vectors (T, 3) on the cube by both pads and the table, without its weight
    table               upward force of the table (T,)
    readings            sums (T, 2) of the frames of the left and right pad, as the controller sees them
    fingers_m           distance (T,) of each pad from the middle plane; raised_m: height (T,) of the fingers
    """

    time_s: Array
    position: Array
    velocity: Array
    on_left: Array
    on_right: Array
    on_cube: Array
    table: Array
    readings: Array
    fingers_m: Array
    raised_m: Array


def lift_cube(grasp: Grasp | None = None, pad: TaxelPad | None = None) -> GraspHistory:
    """Close on the cube, hold it with the wanted force, lift it; two equal flat pads, by default the nominal ones.

    Example: `history = lift_cube(); history.position[-1, 2]` is how far the cube was lifted.

    Raises ValueError for a task that is not finite or cannot be (a mass or grip that is not > 0), or where `dt_s` is
    too long for pads and cube (the step needed is named), or where the cube goes deeper into a pad than its limit.
    """
    grasp, pad = grasp or Grasp(), pad or TaxelPad()
    _refuse_long_steps(grasp, pad)
    dt, half = grasp.dt_s, grasp.edge_mm * 0.5e-3
    steps = round(grasp.duration_s / dt)
    every = max(1, round(1 / (pad.parameters.frame_rate_hz * dt)))
    position, velocity = np.array([grasp.offset_mm * 1e-3, 0.0, 0.0]), np.zeros(3)
    fingers, raised, closing = half + abs(grasp.offset_mm) * 1e-3 + 2e-4, 0.0, 0.0
    bristles = [pad.at_rest(), pad.at_rest()]
    seen = np.zeros(2)
    rows = []
    for step in range(steps):
        time = step * dt
        rising = grasp.lift_mm_s * 1e-3 if time >= grasp.lift_at_s and raised < grasp.lift_mm * 1e-3 else 0.0
        on_pads = []
        for side, frame in enumerate((_LEFT, _RIGHT)):
            sign = -1.0 if side == 0 else 1.0
            place = np.array([sign * fingers, 0.0, raised])
            moving = velocity - (-sign * closing, 0.0, rising)
            centre = frame.T @ (position - place)
            cube = Box((float(centre[0]), float(centre[1]), float(centre[2])), (half, half, half))
            depth = pad.depth(cube)
            relative = np.broadcast_to(frame.T @ moving, (len(depth), 3))
            forces = pad.forces(bristles[side], depth, relative, dt)
            bristles[side] = forces.bristle
            on_pads.append(frame @ forces.vectors.sum(axis=0))
            if step % every == 0:
                seen[side] = pad.read(forces.normal).sum(dtype=np.float64)
        sunk = max(0.0, -position[2])
        table = max(0.0, _TABLE_N_PER_M * sunk - _TABLE_NS_PER_M * velocity[2]) if sunk > 0 else 0.0
        # what the pads feel, the cube feels with the other sign
        on_cube = np.array([0.0, 0.0, table]) - on_pads[0] - on_pads[1]
        rows.append(np.concatenate(([time], position, velocity, *on_pads, on_cube, [table], seen, [fingers, raised])))
        velocity = velocity + dt * (on_cube / grasp.mass_kg + GRAVITY)
        position = position + dt * velocity
        wanted = grasp.gain_m_per_ns * (grasp.grip_n - seen.mean())
        closing = float(np.clip(wanted, -grasp.close_mm_s * 1e-3, grasp.close_mm_s * 1e-3))
        fingers, raised = fingers - dt * closing, raised + dt * rising
    parts = np.split(np.array(rows), np.cumsum([1, 3, 3, 3, 3, 3, 1, 2, 1]), axis=1)
    time_s, position_, velocity_, left, right, cube_, table_, readings, fingers_, raised_ = parts
    return GraspHistory(
        time_s[:, 0], position_, velocity_, left, right, cube_, table_[:, 0], readings, fingers_[:, 0], raised_[:, 0]
    )


def _refuse_long_steps(grasp: Grasp, pad: TaxelPad) -> None:
    """Symplectic steps are stable while springs and dampers of all elements at once are slower than the step."""
    for name, value in vars(grasp).items():
        if not math.isfinite(value) or (value < 0 and name != "offset_mm"):
            raise ValueError(f"a grasp needs finite values >= 0, got {name} = {value}")
    if not (grasp.mass_kg > 0 and grasp.edge_mm > 0 and grasp.grip_n > 0 and grasp.duration_s >= grasp.dt_s > 0):
        raise ValueError(
            "a grasp needs mass_kg > 0, edge_mm > 0, grip_n > 0 and duration_s >= dt_s > 0, got "
            f"{grasp.mass_kg}, {grasp.edge_mm}, {grasp.grip_n}, {grasp.duration_s} and {grasp.dt_s}"
        )
    p, elements = pad.parameters, 2 * len(pad.layout)
    stiffest = elements * max(p.stiffness_n_per_m, p.bristle_n_per_m) + _TABLE_N_PER_M
    damper = elements * max(p.damping_ns_per_m, p.bristle_damping_ns_per_m) + _TABLE_NS_PER_M
    longest = min(1 / math.sqrt(stiffest / grasp.mass_kg), grasp.mass_kg / damper)
    count_substeps(grasp.dt_s, longest, substeps=1)
