"""The forms whose cost is compared give the same scores."""

import numpy as np
import pytest

from slip.covariance import covariance_norm, plain_norm
from slip.timing import covariance_cost, lean_norm


@pytest.mark.parametrize("window", [2, 50])
def test_the_plain_forms_score_what_the_detector_scores(window):
    force = np.random.default_rng(0).standard_normal((300, 16))
    scores = covariance_norm(force, window)
    np.testing.assert_allclose(plain_norm(force, window), scores, rtol=1e-12)
    np.testing.assert_allclose(lean_norm(force, window), scores, rtol=1e-12)


def test_every_form_has_its_cost_relative_to_the_batch():
    batch, *others = covariance_cost(window=5, taxels=4, repeats=2)
    assert batch.ratio == (1.0, 1.0, 1.0)
    assert len(others) == 3
    for cost in others:
        assert cost.us[1] <= cost.us[0] <= cost.us[2]
        assert cost.ratio[1] >= cost.us[1] / batch.us[2] * (1 - 1e-9)
        assert cost.ratio[2] <= cost.us[2] / batch.us[1] * (1 + 1e-9)


@pytest.mark.parametrize("wrong", [{"window": 1}, {"taxels": 0}, {"repeats": 0}])
def test_nothing_to_measure_is_refused(wrong):
    with pytest.raises(ValueError, match="expected"):
        covariance_cost(**wrong)
