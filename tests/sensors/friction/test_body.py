"""Free bodies under LuGre: rest, break-away, sliding to a stop, and refusal of steps that cannot be stable."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sensors.friction.body import MOST_SUBSTEPS, advance_body, count_substeps, needed_step
from sensors.friction.lugre import LuGre
from sensors.friction.patch import PatchState, SkinPatch

LAW = LuGre(1e5, damping=20.0, viscosity=0.0)
MASS = 0.1
LOAD = np.array(MASS * 9.81)


def push(force_n, seconds, velocity=0.0, law=LAW):
    v, z, x = np.array([velocity]), np.zeros(1), np.zeros(1)
    for _ in range(round(seconds * 1000)):
        v, z, moved = advance_body(law, MASS, v, z, np.array([force_n]), LOAD, 1e-3)
        x = x + moved
    return v[0], z[0], x[0]


def test_a_body_pushed_below_static_friction_comes_to_rest_on_its_bristles():
    velocity, bristle, moved = push(0.4 * LOAD, 1.0)
    assert velocity == pytest.approx(0, abs=1e-6)
    assert 1e5 * bristle == pytest.approx(0.4 * LOAD, rel=1e-3)
    # the swing after a sudden push reaches 0.8 of the load, past break-away: it slips a little before it sticks
    assert 0.4 * LOAD / 1e5 <= moved < 10 * 0.4 * LOAD / 1e5


def test_a_body_pushed_above_static_friction_accelerates_by_the_rest():
    velocity, _, _ = push(1.2 * LOAD, 0.5)
    expected = (1.2 - 0.5) * LOAD / MASS * 0.5
    assert velocity == pytest.approx(expected, rel=0.02)


def test_a_sliding_body_stops_after_the_braking_distance():
    velocity, _, moved = push(0.0, 1.0, velocity=0.5)
    assert velocity == pytest.approx(0, abs=1e-6)
    assert moved == pytest.approx(0.5**2 / (2 * 0.5 * 9.81), rel=0.02)


def test_a_push_agrees_with_a_tight_reference():
    def derivative(t, y):
        v, z = y
        rate = LAW.rate(np.array([v]), LOAD)
        force = LAW.force(np.array([z]), np.array([v]), LOAD)[0]
        return [(0.9 * LOAD - force) / MASS, v - rate * z]

    truth = solve_ivp(derivative, (0, 0.05), [0.0, 0.0], "Radau", rtol=1e-8, atol=1e-12).y[0, -1]
    v, z = np.zeros(1), np.zeros(1)
    for _ in range(50):
        v, z, _ = advance_body(LAW, MASS, v, z, np.array([0.9 * LOAD]), LOAD, 1e-3, substeps=20)
    assert v[0] == pytest.approx(truth, rel=0.01)


def test_unloaded_bodies_fly_free():
    v, z, moved = advance_body(LAW, MASS, np.array([0.2]), np.array([1e-5]), np.array([0.5]), np.array(0.0), 0.01)
    assert v == pytest.approx(0.2 + 0.5 / MASS * 0.01)
    assert z == pytest.approx(0)
    assert moved == pytest.approx(0.002, rel=0.25)


def test_bodies_are_advanced_together_as_apart():
    rng = np.random.default_rng(0)
    v, z, f = rng.normal(0, 0.01, (5, 2)), np.zeros((5, 2)), rng.normal(0, 1, (5, 2))
    together = advance_body(LAW, MASS, v, z, f, np.full(5, 1.0), 1e-3)
    for body in range(5):
        alone = advance_body(LAW, MASS, v[body], z[body], f[body], np.array(1.0), 1e-3)
        for joint, single in zip(together, alone, strict=True):
            assert joint[body] == pytest.approx(single)


def test_a_step_that_cannot_be_stable_is_refused_with_the_step_it_needs():
    assert needed_step(1e5, 0.1) == pytest.approx(1e-3)
    assert count_substeps(1e-3, needed_step(1e5, 0.1)) == 1
    assert count_substeps(1e-3, needed_step(1e6, 0.1)) == 4
    with pytest.raises(ValueError, match=r"at most 0\.000316 s, so 4 substeps"):
        count_substeps(1e-3, needed_step(1e6, 0.1), substeps=1)
    with pytest.raises(ValueError, match="need steps of at most"):
        advance_body(LAW, 1e-3, np.zeros(2), np.zeros(2), np.zeros(2), np.array(1.0), 1e-3, substeps=2)
    for mass in (0.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="mass_kg"):
            needed_step(1e5, mass)


def test_a_mass_too_light_for_any_affordable_substeps_is_refused_by_name():
    assert count_substeps(1e-3, needed_step(1e6, 1.01e-6)) <= MOST_SUBSTEPS
    with pytest.raises(
        ValueError, match=r"step of 0\.001 s .* mass of 1e-09 kg .* steps of 3\.16e-08 s, 31623 in each"
    ):
        advance_body(LuGre(1e6), 1e-9, np.zeros(2), np.zeros(2), np.zeros(2), np.array(1.0), 1e-3)
    patch, still = SkinPatch(LuGre(np.array([1e6])), 1e-9, 1.0, 0.0), np.zeros((1, 2))
    with pytest.raises(ValueError, match=r"mass of 1e-09 kg"):
        patch.advance(PatchState.at_rest(1), still, still, np.ones(1), 1e-3)
