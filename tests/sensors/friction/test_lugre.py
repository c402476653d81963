"""LuGre in prescribed motion: second order, stable where Euler diverges, and the laws of friction."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sensors.friction.lugre import LuGre

LOAD = 2.0
DT = 1e-3


def velocity_at(time):
    """A start, a reversal and a turn: mm/s on a plane."""
    return 0.02 * np.stack((np.sin(2 * np.pi * 2 * time), 0.5 * (1 - np.cos(2 * np.pi * 1.5 * time))), axis=-1)


def run(law, velocity, load, dt=DT):
    """Force (T, d) along a sampled velocity (T, d) from rest."""
    bristle, forces = np.zeros(velocity.shape[1:]), [np.zeros(velocity.shape[1:])]
    for before, after in pairwise(velocity):
        bristle, force = law.advance(bristle, before, after, load, dt)
        forces.append(force)
    return np.array(forces)


def reference(law, time):
    def bristle_rate(t, z):
        v = velocity_at(np.asarray(t))
        return v - law.rate(v[None], np.array([LOAD]))[0] * z

    solution = solve_ivp(bristle_rate, (0, time[-1]), np.zeros(2), "LSODA", time, rtol=1e-9, atol=1e-14, max_step=1e-3)
    return law.force(solution.y.T, velocity_at(time), np.full(len(time), LOAD))


def test_error_falls_with_the_square_of_the_step():
    law = LuGre(2e4, damping=0.3, viscosity=0.4)
    fine = np.arange(0, 0.3, 1e-4)
    truth = reference(law, fine)
    errors = [
        np.abs(run(law, velocity_at(fine[::skip]), np.array(LOAD), skip * 1e-4) - truth[::skip]).max()
        for skip in (4, 2, 1)
    ]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.25)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.25)


def test_explicit_euler_diverges_where_the_exponential_step_is_stable():
    law = LuGre(1e5)
    velocity = np.full((500, 1), 0.05)
    bristle = np.zeros(1)
    assert 2 * law.level(LOAD, np.array(0.05)) / (1e5 * 0.05) < DT
    for v in velocity[:200]:
        bristle = bristle + DT * (v - law.rate(v, np.array(LOAD))[..., None] * bristle)
    assert abs(1e5 * bristle[0]) > 1e6
    assert run(law, velocity, np.array(LOAD))[-1] == pytest.approx(law.steady_force(velocity[-1], np.array(LOAD)))


def test_sticking_has_the_stiffness_of_the_bristles():
    law = LuGre(4e4)
    step = np.array([1e-9])  # metres, a hair of the breakaway distance
    _, force = law.advance(np.zeros(1), step / DT, step / DT, np.array(LOAD), DT)
    assert force / step == pytest.approx(4e4, rel=1e-4)


@pytest.mark.parametrize("speed", [1e-3, 5e-3, 0.05])
def test_steady_sliding_is_the_stribeck_curve_along_the_motion(speed):
    law = LuGre(1e5, damping=5.0, viscosity=0.4)
    direction = np.array([0.6, -0.8])
    force = run(law, np.tile(speed * direction, (2000, 1)), np.array(LOAD))[-1]
    expected = LOAD * (0.5 + 0.1 * np.exp(-((speed / 5e-3) ** 2))) + 0.4 * speed
    assert force == pytest.approx(expected * direction, rel=1e-6)
    assert force == pytest.approx(law.steady_force(speed * direction, np.array(LOAD)), rel=1e-6)


def test_bristles_never_hold_more_than_static_friction():
    law, rng = LuGre(1e5), np.random.default_rng(1)
    velocity = rng.normal(0, 0.05, (2000, 8, 2))
    bristle = np.zeros((8, 2))
    for before, after in pairwise(velocity):
        bristle, _ = law.advance(bristle, before, after, np.full(8, LOAD), DT)
        assert (1e5 * np.linalg.norm(bristle, axis=1) <= 0.6 * LOAD * (1 + 1e-9)).all()


def test_without_load_there_is_neither_force_nor_bristle():
    law = LuGre(1e5, damping=1.0, viscosity=1.0)
    bristle, force = law.advance(
        np.full((3, 2), 1e-5), np.full((3, 2), 0.1), np.full((3, 2), 0.1), np.array([0.0, 1.0, 0.0]), DT
    )
    assert (bristle[[0, 2]] == 0).all()
    assert (force[[0, 2]] == 0).all()
    assert (force[1] != 0).all()
    assert (law.steady_force(np.full((1, 2), 0.1), np.zeros(1)) == 0).all()


def test_a_falling_load_cuts_the_bristle_back_without_motion():
    law, still = LuGre(1e4), np.zeros(2)
    held = np.array([1.1 / 1e4, 0.0])
    bristle, force = law.advance(held, still, still, np.array(1.0), DT)
    assert force == pytest.approx([0.6, 0.0])
    untouched, _ = law.advance(held, still, still, np.array(2.0), DT)
    assert untouched == pytest.approx(held)
    assert bristle[0] < held[0]


@pytest.mark.parametrize("seed", range(3))
def test_friction_takes_energy_while_the_speed_is_passive(seed):
    law, rng = LuGre(1e4, damping=2.0, viscosity=0.1), np.random.default_rng(seed)
    dt = 3e-5
    limit = law.passive_speed(np.array(LOAD))
    wander = np.cumsum(rng.normal(0, 1, (6000, 2)), axis=0)
    velocity = 0.5 * min(limit, 0.1) * wander / np.linalg.norm(wander, axis=1).max()
    force = run(law, velocity, np.array(LOAD), dt)
    power = (force * velocity).sum(axis=1)
    assert (np.cumsum(power) * dt >= -1e-9).all()


def test_elements_do_not_see_each_other():
    law, rng = LuGre(np.array([1e3, 1e4, 1e5]), damping=0.5), np.random.default_rng(2)
    velocity, load = rng.normal(0, 0.02, (50, 3, 2)), np.array([0.5, 1.0, 2.0])
    together = run(law, velocity, load)
    for element, stiffness in enumerate((1e3, 1e4, 1e5)):
        alone = run(LuGre(stiffness, damping=0.5), velocity[:, element], load[element])
        assert together[:, element] == pytest.approx(alone)


@pytest.mark.parametrize(
    "change",
    [
        {"stiffness": 0.0},
        {"stiffness": np.inf},
        {"stiffness": np.array([1e4, np.nan])},
        {"damping": -1.0},
        {"damping": np.nan},
        {"viscosity": np.inf},
        {"dynamic": 0.7},
        {"static": np.inf},
        {"stribeck_m_per_s": 0.0},
        {"stribeck_m_per_s": np.inf},
    ],
    ids=str,
)
def test_impossible_laws_are_refused(change):
    with pytest.raises(ValueError, match="LuGre needs"):
        LuGre(**({"stiffness": 1e4} | change))


def test_a_step_without_length_is_refused():
    with pytest.raises(ValueError, match="dt_s"):
        LuGre(1e4).advance(np.zeros(2), np.zeros(2), np.zeros(2), np.array(1.0), 0.0)


def test_a_motion_followed_whole_is_the_same_step_by_step():
    rng = np.random.default_rng(4)
    law = LuGre(np.geomspace(1e3, 1e6, 7), damping=0.3, viscosity=0.4)
    # two stretches of what fits in the cache, and loads that vanish now and then
    velocity, load = rng.normal(0, 0.02, (900, 7, 2)), np.maximum(rng.normal(1, 1, (900, 7)), 0)
    bristles, forces = law.follow(velocity, load, DT)
    bristle = np.zeros((7, 2))
    for t in range(1, 900):
        bristle, force = law.advance(bristle, velocity[t - 1], velocity[t], load[t], DT)
        assert np.array_equal(bristle, bristles[t])
        assert np.array_equal(force, forces[t])
    assert np.abs(forces).max() > 0.5


def test_a_motion_of_the_wrong_shape_is_refused():
    with pytest.raises(ValueError, match="expected velocity"):
        LuGre(1e4).follow(np.zeros((5, 2)), np.zeros(5), DT)
    with pytest.raises(ValueError, match="dt_s"):
        LuGre(1e4).follow(np.zeros((5, 1, 2)), np.zeros((5, 1)), 0.0)
    with pytest.raises(ValueError, match="finite"):
        LuGre(1e4).follow(np.full((5, 1, 2), np.nan), np.zeros((5, 1)), DT)
