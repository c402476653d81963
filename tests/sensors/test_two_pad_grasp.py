"""Two pads and a cube: action equals reaction, momentum, weight on the pads, slip of what is too heavy."""

from dataclasses import replace

import numpy as np
import pytest

from sensors.taxel_pad import TaxelPad, TaxelPadParameters
from sensors.two_pad_grasp import GRAVITY, Grasp, lift_cube

GRASP = Grasp(lift_at_s=0.5, duration_s=1.2)
SOFT = TaxelPad(TaxelPadParameters(rows=6, columns=4))


@pytest.fixture(scope="module")
def lifted():
    return lift_cube(GRASP, SOFT)


def test_the_cubes_motion_shows_the_reaction_of_what_the_pads_feel(lifted):
    # the acceleration is measured on the path, the forces on the pads: within 1e-9 of the grip at every step
    acceleration = np.diff(lifted.position, 2, axis=0) / GRASP.dt_s**2
    table = np.zeros((len(acceleration), 3))
    table[:, 2] = lifted.table[1:-1]
    from_pads = 0.2 * (acceleration - GRAVITY) - table
    assert np.abs(from_pads + lifted.on_left[1:-1] + lifted.on_right[1:-1]).max() < 1e-6 * GRASP.grip_n
    assert np.abs(lifted.on_left).max() > 5


def test_at_rest_the_pads_press_alike_and_carry_the_weight(lifted):
    left, right = lifted.on_left[-1], lifted.on_right[-1]
    assert left[0] == pytest.approx(-right[0], rel=1e-3)
    assert -(left + right)[2] * -1 == pytest.approx(-0.2 * 9.81, rel=1e-2)
    assert lifted.table[-1] == 0


def test_the_controller_holds_the_wanted_grip_by_its_pads_alone(lifted):
    assert lifted.readings[-200:] == pytest.approx(GRASP.grip_n, rel=0.01)
    # what the pads read is what they feel, to the steps of the converter
    steps = SOFT.step_n * len(SOFT.layout) / 2
    assert lifted.readings[-1, 0] == pytest.approx(-lifted.on_left[-1, 0], abs=steps)


def test_the_cube_follows_the_fingers_and_started_off_the_middle(lifted):
    assert lifted.position[0, 0] == pytest.approx(3e-4)
    assert lifted.position[-1, 2] == pytest.approx(lifted.raised_m[-1], abs=5e-4)
    assert lifted.raised_m[-1] == pytest.approx(0.02, rel=0.01)
    assert np.abs(lifted.velocity[-1]).max() < 1e-4


def test_a_cube_too_heavy_for_the_friction_slips_at_coulombs_force():
    history = lift_cube(replace(GRASP, mass_kg=1.5, duration_s=0.9), SOFT)
    upward = -(history.on_left + history.on_right)[-50:, 2]
    pressed = np.abs(history.on_left[-50:, 0]) + np.abs(history.on_right[-50:, 0])
    assert upward == pytest.approx(0.6 * pressed, rel=0.05)
    assert history.position[-1, 2] < 0.2 * history.raised_m[-1]


def test_steps_that_cannot_be_stable_are_refused_with_the_step_they_need():
    with pytest.raises(ValueError, match="need steps of at most"):
        lift_cube(replace(GRASP, dt_s=0.02), SOFT)
    with pytest.raises(ValueError, match="need steps of at most"):
        lift_cube(GRASP, TaxelPad(TaxelPadParameters(bristle_n_per_m=1e6)))
    with pytest.raises(ValueError, match="mass_kg"):
        lift_cube(Grasp(mass_kg=0.0))
