"""A dragged patch of skin: springs in series, rim first, Coulomb in the end, stick-slip below critical stiffness."""

from itertools import pairwise

import numpy as np
import pytest

from sensors.friction.lugre import LuGre
from sensors.friction.patch import PatchState, SkinPatch

DT = 1e-3
LOAD = np.array([0.5, 1.0, 1.5, 2.0])
BRISTLES = np.full(4, 3e3)
SKIN = SkinPatch(LuGre(BRISTLES, damping=0.3), mass_kg=2e-3, stiffness=12e3, damping=1.0)


def drag(patch, speed, samples, load=LOAD, direction=(1.0, 0.0), dt=DT, substeps=None):
    """States along a drive that reaches `speed` in 20 ms."""
    state, states = PatchState.at_rest(len(load)), []
    ramp = speed * np.minimum(np.arange(samples + 1) * dt / 0.02, 1)
    for before, after in pairwise(ramp):
        along = np.array([direction])
        state = patch.advance(state, before * along, after * along, load, dt, substeps)
        states.append(state)
    return states


def test_a_small_shift_is_shared_by_springs_in_series():
    moved = 2e-6
    states = drag(SKIN, 0.0, 1)
    state = states[-1]
    for _ in range(400):
        drive = np.array([[moved / 0.4, 0.0]])
        state = SKIN.advance(state, drive, drive, 100 * LOAD, DT)
    still = np.zeros((1, 2))
    for _ in range(300):
        state = SKIN.advance(state, still, still, 100 * LOAD, DT)
    series = 1 / (1 / SKIN.stiffness + 1 / BRISTLES.sum())
    assert state.force.sum(axis=0) == pytest.approx([series * moved, 0], rel=0.01)
    assert state.displacement[0] == pytest.approx(series * moved / SKIN.stiffness, rel=0.01)
    assert np.abs(state.slip).max() < 0.01 * moved


def test_in_steady_sliding_the_skin_holds_the_coulomb_force():
    direction = np.array([0.6, 0.8])
    state = drag(SKIN, 0.05, 1500, direction=direction)[-1]
    assert state.force.sum(axis=0) == pytest.approx(0.5 * LOAD.sum() * direction, rel=1e-3)
    assert SKIN.stiffness * state.displacement == pytest.approx(0.5 * LOAD.sum() * direction, rel=1e-3)
    speed = state.slip - drag(SKIN, 0.05, 1499, direction=direction)[-1].slip
    assert speed / DT == pytest.approx(np.tile(0.05 * direction, (4, 1)), rel=1e-3)
    drive = 0.05 * direction[None]
    assert SKIN.utilisation(state, drive, LOAD) == pytest.approx(np.ones(4), rel=1e-3)


def test_the_lightly_loaded_elements_slip_first():
    states = drag(SKIN, 0.01, 400)
    used = np.array([SKIN.utilisation(state, np.array([[0.01, 0.0]]), LOAD) for state in states])
    first_loose = (used > 0.63).argmax(axis=0)
    assert (np.diff(first_loose) > 0).all()


def test_what_is_not_slip_is_strain():
    states = drag(SKIN, 0.01, 300)
    state = states[-1]
    driven = 0.01 * (0.3 - 0.01)
    total = state.slip + state.bristle + state.displacement
    assert total[:, 0] == pytest.approx(np.full(4, driven), rel=1e-6)
    assert total[:, 1] == pytest.approx(0, abs=1e-15)


def test_unloaded_elements_neither_drag_nor_slip():
    load = np.array([0.0, 1.0, 0.0, 1.0])
    state = drag(SKIN, 0.02, 300, load)[-1]
    assert (state.force[load == 0] == 0).all()
    assert (state.bristle[load == 0] == 0).all()
    assert state.force[1, 0] > 0.4


def test_the_scheme_converges_with_its_substeps():
    coarse = np.array([state.displacement[0] for state in drag(SKIN, 0.02, 200)])
    fine = np.array([state.displacement[0] for state in drag(SKIN, 0.02, 200, substeps=100)])
    assert np.abs(coarse - fine).max() < 0.02 * np.abs(fine).max()


@pytest.mark.parametrize(("spring", "swings"), [(0.2, True), (5.0, False)])
def test_stick_slip_lives_below_the_critical_stiffness(spring, swings):
    # stiff bristles: their length g / sigma0 is the memory of the interface
    load = np.full(4, 1.0)
    law = LuGre(np.full(4, 2e4), damping=0.2, static=0.8, dynamic=0.5, stribeck_m_per_s=0.02)
    memory = 0.8 * load.sum() / law.stiffness.sum()
    critical = 0.3 * load.sum() / memory
    stiffness = spring * critical
    mass = 0.05
    patch = SkinPatch(law, mass, stiffness, 0.02 * 2 * np.sqrt(stiffness * mass))
    held = np.array([state.displacement[0] for state in drag(patch, 0.005, 3000, load)]) * stiffness
    swing = np.ptp(held[1500:]) / held[1500:].mean()
    assert (swing > 0.05) == swings


def test_a_turning_body_drags_each_element_its_own_way():
    place = np.array([[1e-2, 0.0], [0.0, 1e-2], [-1e-2, 0.0], [0.0, -1e-2]])
    drive = 3.0 * np.stack((-place[:, 1], place[:, 0]), axis=1)
    load, state = np.ones(4), PatchState.at_rest(4)
    for _ in range(500):
        state = SKIN.advance(state, drive, drive, load, DT)
    assert state.force.sum(axis=0) == pytest.approx([0, 0], abs=1e-6)
    torque = (place[:, 0] * state.force[:, 1] - place[:, 1] * state.force[:, 0]).sum()
    assert torque == pytest.approx(4 * 0.5 * 1e-2, rel=0.01)


def test_too_few_substeps_are_refused():
    assert SKIN.longest_step == pytest.approx(np.sqrt(2e-3 / 24e3))
    with pytest.raises(ValueError, match="so 4 substeps"):
        SKIN.advance(PatchState.at_rest(4), np.zeros((1, 2)), np.zeros((1, 2)), LOAD, DT, substeps=1)


def in_numpy(patch, state, drive, next_drive, load, dt, count):
    """`SkinPatch.advance` from the law's own functions, all elements at a time."""
    law, h, loaded = patch.law, dt / count, (load > 0)[:, None]
    sigma0, sigma1, sigma2 = (np.broadcast_to(s, load.shape)[:, None] for s in (law.stiffness, law.damping, 0.2))
    u, w, slip, z = state.displacement, state.velocity, state.slip, law.hold(state.bristle, load) * loaded
    forgotten, reach = (part[:, None] for part in law.memory(drive - w, load, h))
    for number in range(count):
        body = drive + (next_drive - drive) * ((number + 0.5) / count)
        grip = (sigma1 * reach + sigma2 * h) * loaded
        pull = ((h * sigma0 - sigma1 * forgotten) * z * loaded + grip * body).sum(axis=0)
        w = (patch.mass_kg * w + pull - h * patch.stiffness * u) / (patch.mass_kg + h * patch.damping + grip.sum())
        forgotten, reach = (part[:, None] for part in law.memory(body - w, load, h))
        change = (reach * (body - w) - forgotten * z) * loaded
        z, slip, u = z + change, slip + (h * (body - w) - change) * loaded, u + h * w
    force = (sigma0 * z + sigma1 * change / h + sigma2 * (body - w)) * loaded
    return PatchState(u, w, z, slip, force)


@pytest.mark.parametrize("shared", [True, False])
def test_the_compiled_step_is_the_law_element_by_element(shared):
    rng = np.random.default_rng(0)
    patch = SkinPatch(LuGre(BRISTLES, damping=0.3, viscosity=0.2), mass_kg=2e-3, stiffness=12e3, damping=1.0)
    ours = theirs = PatchState.at_rest(4)
    drive = np.zeros((1 if shared else 4, 2))
    for _ in range(300):
        following = drive + 2e-3 * rng.standard_normal(drive.shape)
        load = np.maximum(LOAD * rng.uniform(-0.2, 1.0, 4), 0.0)  # also cut back, also let go
        ours = patch.advance(ours, drive, following, load, DT, substeps=5)
        theirs = in_numpy(patch, theirs, drive, following, load, DT, 5)
        drive = following
    for name in ("displacement", "velocity", "bristle", "slip", "force"):
        mine, reference = getattr(ours, name), getattr(theirs, name)
        assert np.abs(mine - reference).max() <= 1e-12 * np.abs(reference).max(), name
