"""Both nets pass scikit-learn's own checks with their defaults, without exemptions."""

import pytest
from sklearn.utils.estimator_checks import parametrize_with_checks

from fusion.neural import FusionTransformer, LateFusionNet


@pytest.mark.slow
@parametrize_with_checks([LateFusionNet(), FusionTransformer()])
def test_estimator_passes(estimator, check):
    check(estimator)
