"""The error table of LuGre at 1 kHz, and stability over the whole range of what a user may enter."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sensors.friction.accuracy import LOAD_N, euler, main, motion, nominal_law, reference, stepped
from sensors.friction.body import advance_body
from sensors.friction.lugre import LuGre

# % of the friction limit, at 1 kHz; four times the rate leaves a tenth of it or less, but for the stiffest
BOUNDS = {1e3: 0.003, 1e4: 0.03, 1e5: 0.3, 1e6: 1.5}


@pytest.mark.parametrize("stiffness", list(BOUNDS))
def test_a_millisecond_step_is_accurate_from_soft_to_stiff(stiffness):
    law, time = nominal_law(stiffness), np.arange(0, 0.5, 1e-3)
    error = np.abs(stepped(law, time) - reference(law, time)).max()
    assert 100 * error / (law.static * LOAD_N) < BOUNDS[stiffness]


def test_the_reference_has_converged_and_euler_is_worse():
    law, time = nominal_law(1e4), np.arange(0, 0.3, 1e-3)
    fine = np.arange(0, 0.3, 1e-5)
    truth = reference(law, time)
    assert stepped(law, fine)[::100] == pytest.approx(truth, abs=1e-6)
    ours, plain = (np.abs(step(law, time) - truth).max() for step in (stepped, euler))
    assert plain > 20 * ours
    assert np.abs(euler(nominal_law(1e6), time)).max() > 100 * LOAD_N


@settings(max_examples=60, deadline=None)
@given(
    stiffness=st.floats(0, 9), damping=st.floats(-3, 4), load=st.floats(-9, 4), dt=st.floats(-6, 1),
    speed=st.floats(-6, 2), dynamic=st.floats(0.01, 2), extra=st.floats(0, 2), seed=st.integers(0, 99),
)  # fmt: skip
def test_prescribed_motion_is_bounded_for_every_law_and_step(stiffness, damping, load, dt, speed, dynamic, extra, seed):
    law = LuGre(10**stiffness, 10**damping, 0.1, dynamic + extra, dynamic, 5e-3)
    rng = np.random.default_rng(seed)
    velocity = 10**speed * rng.uniform(-1, 1, (60, 3, 2))
    normal = 10**load * rng.uniform(0, 1, (60, 3))
    bristle, force = law.follow(velocity, normal, 10**dt)
    most = np.maximum.accumulate(law.static * normal, axis=0)
    length = np.linalg.norm(bristle, axis=-1)
    assert (10**stiffness * length <= most * (1 + 1e-6)).all()
    # |z'| <= |v| (1 + sigma0 |z| / g)
    pulled = 1 + 10**stiffness * length / (dynamic * np.maximum(normal, 1e-300))
    bound = 10**stiffness * length + (10**damping * pulled + 0.1) * np.linalg.norm(velocity, axis=-1)
    assert (np.linalg.norm(force, axis=-1) <= bound * (1 + 1e-6) + 1e-12).all()


@settings(max_examples=30, deadline=None)
@given(stiffness=st.floats(1, 6.5), mass=st.floats(-2, 1), seed=st.integers(0, 99))
def test_free_bodies_come_to_rest_for_every_stiffness_and_mass(stiffness, mass, seed):
    law = LuGre(10**stiffness, damping=0.2 * np.sqrt(10 ** (stiffness + mass)), viscosity=0.5)
    rng = np.random.default_rng(seed)
    weight = np.array(10**mass * 9.81)
    v, z = 0.05 * rng.uniform(-1, 1, 2), np.zeros(2)
    start = 0.5 * 10**mass * float(v @ v)
    for _ in range(60):
        v, z, _ = advance_body(law, 10**mass, v, z, np.zeros(2), weight, 1e-3)
        energy = 0.5 * 10**mass * float(v @ v) + 0.5 * 10**stiffness * float(z @ z)
        assert energy <= start * 1.01 + 1e-12


def test_the_motion_starts_at_rest_and_turns():
    velocity = motion(np.linspace(0, 0.5, 100))
    assert velocity[0] == pytest.approx([0, 0])
    assert (velocity[:, 0] < 0).any()
    assert (velocity[:, 0] > 0.01).any()


@pytest.mark.slow
def test_the_command_prints_every_stiffness(capsys):
    assert main([]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 9
    assert "diverges" in lines[5]
