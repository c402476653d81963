"""Arrays that differ from the nominal one: gains, offsets, dead taxels, sessions."""

import numpy as np
import pytest

from sensors.electronics.piezoresistive import PiezoresistiveChain
from sensors.electronics.spread import ArrayTraits

CHAIN = PiezoresistiveChain(noise_v=0.0, hysteresis=None)
LOAD = np.full((3, 4000), 5.0)


def test_the_spread_asked_for_is_the_spread_drawn():
    traits = ArrayTraits.draw(np.random.default_rng(0), 4000, gain_spread=0.05, offset_n=0.1, dead_share=0.25)
    assert np.log(traits.gain).std() == pytest.approx(0.05, rel=0.05)
    assert traits.offset_n.std() == pytest.approx(0.1, rel=0.05)
    assert traits.dead.mean() == pytest.approx(0.25, abs=0.03)


def test_a_dead_taxel_reads_the_same_under_any_load():
    traits = ArrayTraits.draw(np.random.default_rng(1), 4000, dead_share=0.3)
    heavy, none = traits.read(CHAIN, LOAD), traits.read(CHAIN, 0 * LOAD)
    assert (heavy == none)[:, traits.dead].all()
    assert (heavy[:, ~traits.dead] > 4).all()
    assert np.abs(none).max() < 0.1


def test_a_gain_reads_as_a_force_by_the_law_of_the_conductance():
    traits = ArrayTraits.draw(np.random.default_rng(2), 4000, gain_spread=0.1)
    assert traits.read(CHAIN, LOAD) == pytest.approx(LOAD * traits.gain ** (1 / CHAIN.exponent), abs=1e-3)


def test_sessions_walk_away_from_the_first():
    rng = np.random.default_rng(3)
    first = ArrayTraits.draw(rng, 4000)
    later = first
    spread = []
    for _ in range(16):
        later = later.drift(rng, gain=0.01, offset_n=0.02)
        spread.append((later.offset_n - first.offset_n).std())
    assert spread[0] == pytest.approx(0.02, rel=0.1)
    assert spread[-1] == pytest.approx(0.08, rel=0.1)
    assert np.log(later.gain / first.gain).std() == pytest.approx(0.04, rel=0.1)


def test_impossible_spreads_are_refused():
    with pytest.raises(ValueError, match="dead_share in 0"):
        ArrayTraits.draw(np.random.default_rng(0), 4, dead_share=1.5)
