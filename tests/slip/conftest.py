import pytest
import torch
from slip_trials import trial

from slip.neural import NeuralForce, NeuralForceFrames

SMALL = {"channels": 8, "levels": 4, "hidden": 8}


@pytest.fixture(scope="session")
def force_net():
    torch.set_num_threads(1)
    return NeuralForce(**SMALL).fit([trial(seed, seen=False) for seed in range(10)], epochs=6, batch=2, seed=1)


@pytest.fixture(scope="session")
def frames_net():
    torch.set_num_threads(1)
    trials = [trial(seed, felt=seed % 3 != 1, seen=seed % 3 != 2) for seed in range(12)]
    return NeuralForceFrames(**SMALL, embedding=4, grid=8).fit(trials, epochs=12, batch=2, seed=1)
