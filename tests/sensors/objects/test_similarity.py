from itertools import combinations

import numpy as np
import pytest

from sensors.objects import get, names, nearest_pairs
from sensors.objects.similarity import REACH_M, met


@pytest.fixture(scope="module")
def every_pair():
    return nearest_pairs(1000)


def test_every_pair_once_nearest_first(every_pair):
    assert {frozenset(pair[:2]) for pair in every_pair} == {frozenset(p) for p in combinations(names(), 2)}
    distances = [rms for _, _, rms in every_pair]
    assert distances == sorted(distances)
    assert nearest_pairs(3) == every_pair[:3]


def test_no_two_objects_are_the_same_under_the_skin(every_pair):
    assert every_pair[0][2] > 0.1


def test_twins_made_to_be_confused_are_nearer_than_most(every_pair):
    rank = {frozenset(pair[:2]): place for place, pair in enumerate(every_pair)}
    twins = [
        ("battery-aa", "battery-aaa"),
        ("coin-1-euro", "coin-2-euro"),
        ("coin-1-euro", "coin-20-cent"),
        ("pen-hexagonal", "pen-round"),
        ("cap-crown", "cap-screw"),
        ("key-round", "key-square"),
    ]
    for pair in twins:
        assert rank[frozenset(pair)] < len(every_pair) // 5


def test_what_is_met_reaches_from_the_top_down_and_no_further():
    for name in names():
        part = met(name, 64, 0.08, 0.0)
        assert part.min() >= 0.0
        assert part.max() <= 1e3 * REACH_M + 1e-4
        assert part.max() > 2.0, get(name)
        assert np.isfinite(part).all()


def test_count_must_be_positive():
    with pytest.raises(ValueError, match="at least one pair, got 0"):
        nearest_pairs(0)
