"""Penalty forms and the pad's spring: never pulling, inside the cone, finite gradients, no jump at touch."""

import numpy as np
import pytest
import torch

from sensors.friction.pad import PadSpring
from sensors.friction.penalty import normal_force, shear_force

RNG = np.random.default_rng(0)


def test_normal_force_never_pulls_and_needs_penetration():
    depth, rate = RNG.uniform(-1e-3, 1e-3, 1000), RNG.uniform(-10, 10, 1000)
    force = normal_force(depth, rate, 800.0, 400.0)
    assert (force >= 0).all()
    assert (force[depth <= 0] == 0).all()
    inside = depth > 0
    assert force[inside] == pytest.approx(np.maximum(0, (800.0 + 400.0 * rate) * depth)[inside])


def test_shear_is_viscous_below_the_cone_and_coulomb_above():
    slow, fast = np.array([[1e-4, 0.0]]), np.array([[0.3, -0.4]])
    normal = np.array([2.0])
    assert shear_force(slow, normal, 50.0, 0.5) == pytest.approx(-50.0 * slow)
    assert np.linalg.norm(shear_force(fast, normal, 50.0, 0.5)) == pytest.approx(1.0, rel=1e-4)
    assert shear_force(fast, normal, 50.0, 0.5) == pytest.approx(-fast / 0.5, rel=1e-4)


def test_shear_stays_inside_the_cone_and_opposes_the_motion():
    velocity, normal = RNG.normal(size=(500, 2)), RNG.uniform(0, 5, 500)
    force = shear_force(velocity, normal, 100.0, 0.7)
    assert (np.linalg.norm(force, axis=-1) <= 0.7 * normal + 1e-12).all()
    assert ((force * velocity).sum(-1) <= 0).all()


def test_gradients_agree_with_finite_differences_and_are_finite_at_rest():
    depth = torch.tensor([1e-3, 2e-3, -1e-3], dtype=torch.float64, requires_grad=True)
    rate = torch.tensor([0.1, -0.2, 0.3], dtype=torch.float64, requires_grad=True)
    velocity = torch.tensor([[1e-3, 2e-3], [0.4, -0.1], [0.1, 0.1]], dtype=torch.float64, requires_grad=True)
    load = torch.tensor([1.0, 2.0, 0.5], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda d, r: normal_force(d, r, 800.0, 400.0), (depth, rate))
    assert torch.autograd.gradcheck(lambda v, n: shear_force(v, n, 50.0, 0.5), (velocity, load))

    rest = torch.zeros(3, 2, dtype=torch.float64, requires_grad=True)
    shear_force(rest, load, 50.0, 0.5).sum().backward()
    assert rest.grad == pytest.approx(np.full((3, 2), -50.0))
    assert torch.isfinite(load.grad).all()


def test_tensors_and_arrays_agree():
    velocity, normal = RNG.normal(size=(20, 2)), RNG.uniform(0, 5, 20)
    by_torch = shear_force(torch.as_tensor(velocity), torch.as_tensor(normal), 100.0, 0.7)
    assert by_torch.numpy() == pytest.approx(shear_force(velocity, normal, 100.0, 0.7))


def test_penalty_shear_creeps_where_lugre_would_stick():
    # a body under a shear load far inside the cone moves on at f / k_t for ever
    velocity, mass, dt = np.zeros((1, 2)), 0.1, 1e-4
    for _ in range(20000):
        velocity = velocity + dt / mass * (np.array([[0.1, 0.0]]) + shear_force(velocity, np.array([5.0]), 50.0, 0.5))
    assert velocity[0, 0] == pytest.approx(0.1 / 50.0, rel=1e-3)


def test_without_a_floor_on_the_speed_the_gradient_is_refused():
    with pytest.raises(ValueError, match="eps"):
        shear_force(np.zeros((1, 2)), np.ones(1), 50.0, 0.5, eps=0.0)


def test_pad_spring_does_not_jump_at_touch_and_never_pulls():
    pad = PadSpring(stiffness=500.0, damping=20.0, fade_m=2e-4)
    at_touch = pad.force(np.array([-1e-9, 0.0, 1e-9]), np.full(3, 0.5))
    assert at_touch == pytest.approx(0, abs=1e-6)
    assert pad.force(np.array([1e-3]), np.array([0.5])) == pytest.approx(500 * 1e-3 + 20 * 0.5)
    assert pad.force(np.array([1e-3]), np.array([-1.0])) == pytest.approx(0)
    depth = np.linspace(-1e-4, 4e-4, 2001)
    steps = np.diff(pad.force(depth, np.full(2001, 0.5)))
    assert steps.max() < 0.05
    with pytest.raises(ValueError, match="fade_m"):
        PadSpring(500.0, 20.0, 0.0)
