"""Compiled loops give the values of the same Python, also where no cache can be kept, and load numba only when run."""

import subprocess
import sys

import numba
import numpy as np

from sensors.compiled import compiled


def wander(x):
    out = np.empty_like(x)
    state = 0.0
    for t in range(len(x)):
        state = min(max(state * 0.9, x[t] - 0.3), x[t] + 0.3)
        out[t] = state
    return out


def test_values_are_those_of_python_without_a_place_for_the_cache(monkeypatch):
    made, refused = [], []
    njit = numba.njit

    def nowhere_to_cache(*function, **settings):
        # numba's own parts compile through here too
        if function:
            return njit(*function, **settings)

        def compile_one(function):
            if function is wander and settings.get("cache"):
                refused.append(True)
                raise RuntimeError("cannot cache function: no locator available")
            if function is wander:
                made.append(True)
            return njit(**settings)(function)

        return compile_one

    monkeypatch.setattr(numba, "njit", nowhere_to_cache)
    x = np.random.default_rng(0).standard_normal(500)
    run = compiled(wander)
    assert np.array_equal(run(x), wander(x))
    assert np.array_equal(run(x[:7]), wander(x[:7]))
    assert (len(refused), len(made)) == (1, 1)
    assert run.__name__ == "wander"


def test_importing_the_chains_does_not_load_numba():
    code = "import sys, sensors.electronics.piezoresistive, sensors.friction.lugre; print('numba' in sys.modules)"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout == "False\n"
